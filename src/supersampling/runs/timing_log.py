"""Timings in MLflow."""

from collections.abc import Mapping, Sequence

import pandas as pd
from omegaconf import DictConfig

from supersampling.runs import tags
from supersampling.runs.experiment import Experiment
from supersampling.runs.subjects import finished_jobs
from supersampling.runs.timing import TABLE, Timing, table

JOB_TARGET = (1920, 1080)  # target size whose time is logged into a job's run
LOGGED = ("threads", "rounds", "frames", "seconds", "depth")


def log(experiment: Experiment, cfg: DictConfig, timings: Sequence[Timing], tables: Mapping[str, pd.DataFrame]) -> str:
    """Log the times and other tables by file name as a run of kind ``benchmark``; return its id, and leave it open."""
    run_id = experiment.start("benchmark", {tags.KIND: "benchmark"}, None)
    experiment.log_params(run_id, {key: cfg[key] for key in LOGGED})
    experiment.log_params(run_id, {"methods": ", ".join(dict.fromkeys(t.method for t in timings))[:500]})
    for name, content in {TABLE: table(timings), **tables}.items():
        if not content.empty:
            experiment.client.log_table(run_id, content, name)
    return run_id


def log_times_of_jobs(experiment: Experiment, timings: Sequence[Timing]) -> int:
    """Log ``time/<backend>/ms`` into every finished job whose architecture was timed at float32 and 1920x1080.

    The machine becomes a tag of the job. Returns the number of jobs.
    """
    by_architecture: dict[str, list[Timing]] = {}
    for timing in timings:
        if timing.runs and timing.precision == "float32" and (timing.width, timing.height) == JOB_TARGET:
            by_architecture.setdefault(timing.architecture, []).append(timing)
    jobs = 0
    for run_id, subject in finished_jobs(experiment) if by_architecture else ():
        job_timings = by_architecture.get(subject.architecture, [])
        for timing in job_timings:
            experiment.log_metrics(run_id, {f"time/{timing.backend}/ms": timing.ms})
        if job_timings:
            experiment.client.set_tag(run_id, tags.TIMED_ON, job_timings[0].machine)
            jobs += 1
    return jobs
