"""Where timings go in MLflow."""

from collections.abc import Sequence

import pandas as pd
from omegaconf import DictConfig

from supersampling.runs.experiment import Experiment
from supersampling.runs.subjects import finished_jobs
from supersampling.runs.timing import STAGES, TABLE, Timing, table

AT = (1920, 1080)  # the target whose time a job's run gets
SAID = ("threads", "rounds", "frames", "seconds", "depth")


def log(experiment: Experiment, cfg: DictConfig, timings: Sequence[Timing], stages: pd.DataFrame) -> str:
    """A run of kind ``benchmark`` with both tables; gives its id, and leaves it open."""
    run_id = experiment.start("benchmark", {"ss.kind": "benchmark"}, None)
    experiment.log_params(run_id, {key: cfg[key] for key in SAID})
    experiment.log_params(run_id, {"methods": ", ".join(dict.fromkeys(t.method for t in timings))[:500]})
    experiment.client.log_table(run_id, table(timings), TABLE)
    if not stages.empty:
        experiment.client.log_table(run_id, stages, STAGES)
    return run_id


def tell_jobs(experiment: Experiment, timings: Sequence[Timing]) -> int:
    """Log ``time/<backend>/ms`` into every finished job whose architecture was timed at float32 and 1920x1080, and the machine as
    the tag ``ss.timed_on``; gives the number of jobs."""
    known: dict[str, list[Timing]] = {}
    for timing in timings:
        if timing.runs and timing.precision == "float32" and (timing.width, timing.height) == AT:
            known.setdefault(timing.architecture, []).append(timing)
    told = 0
    for run_id, subject in finished_jobs(experiment) if known else ():
        for timing in (found := known.get(subject.architecture, [])):
            experiment.log_metrics(run_id, {f"time/{timing.backend}/ms": timing.ms})
        if found:
            experiment.client.set_tag(run_id, "ss.timed_on", found[0].machine)
            told += 1
    return told
