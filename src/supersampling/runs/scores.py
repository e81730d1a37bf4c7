"""The scores of a run: means as metrics, tables as artifacts."""

import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from mlflow.entities import Run
from mlflow.exceptions import MlflowException

from supersampling.errors import UserError
from supersampling.evaluation.result import Result
from supersampling.metrics import scores
from supersampling.metrics.selection import Metrics
from supersampling.runs import tags
from supersampling.runs.experiment import Experiment

TUNED = "tuned."


def log_result(experiment: Experiment, run_id: str, result: Result, more: Mapping[str, float]) -> None:
    """Log the means as metrics, the tables and the crops as artifacts.

    Metrics that the run was scored by earlier, and that this result does not have, are kept.
    """
    client = experiment.client
    try:
        previous = scores_of(experiment, run_id)
    except UserError as error:  # as a full disk leaves it; the means of its other metrics remain
        sys.stderr.write(f"{error} It is replaced by the scores of this command.\n")
        previous = None
    if previous is not None:
        result = result.merge(previous)
    experiment.log_metrics(run_id, {**result.summary(), **more})
    client.log_table(run_id, result.clips, "clips.json")
    client.log_table(run_id, result.frames, "frames.json")
    with tempfile.TemporaryDirectory(prefix="result") as folder:
        result.write(Path(folder))
        client.log_artifacts(run_id, folder)
    client.set_tag(run_id, tags.METRICS, ",".join(str(m) for m in result.clips if m not in scores.PLACE))


def has_metrics(run: Run, metrics: Metrics) -> bool:
    """Return whether a finished run was scored by all of these."""
    return set(metrics.names) <= set(run.data.tags.get(tags.METRICS, "").split(","))


def tuned_constants(run: Run) -> dict[str, float]:
    """Return the tuned constants of a method that is not learned, by the argument's name."""
    return {k.removeprefix(TUNED): float(v) for k, v in run.data.params.items() if k.startswith(TUNED)}


def means_of(run: Run) -> dict[str, float]:
    """Return a run's means over all clips, by metric."""
    logged = run.data.metrics
    return {k.removeprefix("test/"): v for k, v in logged.items() if k.startswith("test/") and k.count("/") == 1}


def scores_of(experiment: Experiment, run_id: str) -> scores.Scores | None:
    """Return the tables that a run has logged, None if it has none.

    Raises:
        UserError: the table is damaged.
    """
    try:
        path = experiment.artifact(run_id, scores.FILE)
    except (MlflowException, OSError):
        return None
    return scores.read_scores(path)
