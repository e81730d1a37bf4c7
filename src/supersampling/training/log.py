"""An evaluation's result in its MLflow run."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

from mlflow.entities import Run
from mlflow.exceptions import MlflowException

from supersampling.evaluation.result import Result
from supersampling.metrics import scores
from supersampling.metrics.selection import Metrics
from supersampling.training.tracking import Experiment

TAG = "ss.metrics"
"""The metrics that a run was scored by, with commas; one without a value is among them."""


def log_result(experiment: Experiment, run_id: str, result: Result, more: Mapping[str, float]) -> None:
    """Log the means as metrics, the tables and the crops as artifacts; metrics that the run was scored by earlier, and that this
    result does not have, are kept."""
    client = experiment.client
    older = scores_of(experiment, run_id)
    if older is not None:
        result = result.merge(older)
    experiment.log_metrics(run_id, {**result.summary(), **more})
    client.log_table(run_id, result.clips, "clips.json")
    client.log_table(run_id, result.frames, "frames.json")
    with tempfile.TemporaryDirectory(prefix="result") as folder:
        result.write(Path(folder))
        client.log_artifacts(run_id, folder)
    client.set_tag(run_id, TAG, ",".join(str(m) for m in result.clips if m not in scores.PLACE))


def has_metrics(run: Run, metrics: Metrics) -> bool:
    """Whether a finished run was scored by all of these."""
    return set(metrics.names) <= set(run.data.tags.get(TAG, "").split(","))


def tuned_constants(run: Run) -> dict[str, float]:
    """What was tuned of a method that is not learned, by the argument's name."""
    return {k.removeprefix("tuned."): float(v) for k, v in run.data.params.items() if k.startswith("tuned.")}


def means_of(run: Run) -> dict[str, float]:
    """A run's means over all clips, by metric."""
    logged = run.data.metrics
    return {k.removeprefix("test/"): v for k, v in logged.items() if k.startswith("test/") and k.count("/") == 1}


def scores_of(experiment: Experiment, run_id: str) -> scores.Scores | None:
    """The tables that a run has logged, None of one without."""
    try:
        return scores.read_scores(experiment.artifact(run_id, scores.FILE))
    except (MlflowException, OSError):
        return None
