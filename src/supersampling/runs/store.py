"""Finished runs and their artifacts, read through MLflow only, so that a remote server serves as well as a file."""

import json
import os
import re
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pandas as pd
from mlflow.entities import Run as MlflowRun
from mlflow.exceptions import MlflowException

from supersampling.errors import UserError, first_line
from supersampling.metrics import scores
from supersampling.runs import tags
from supersampling.runs.experiment import FINISHED
from supersampling.runs.reach import check_artifacts, find_experiment, open_client
from supersampling.runs.relation import FILES, SAME, SCENES, TRAINED

DOWNLOADS_AT_ONCE = 8
Kind = Literal["job", "evaluation", "benchmark", "stress", "advice"]
PAGE = 500
_SCENE_MEAN = re.compile(r"test/.+/.+")


@dataclass(frozen=True, kw_only=True)
class Run:
    """A finished run of one kind: its tags, flat parameters (as strings) and last metric values."""

    id: str
    name: str
    identity: str
    dataset: str
    method: str
    machine: str
    version: str
    ended: int
    params: dict[str, str]
    metrics: dict[str, float]
    kind: Kind = "job"

    @property
    def model(self) -> str:
        return self.params.get("model", self.method)

    @property
    def seed(self) -> str:
        return self.params.get("seed", "")

    def parameter(self, name: str) -> str | None:
        """Return what was scored or, with ``trained.`` before the name, what was trained; None if it is not known.

        Both are the same unless an evaluation logged otherwise (`supersampling.runs.relation`).
        """
        if name == SCENES and self.kind == "job":
            return None if self.params.get("data") == FILES else SAME
        return self.params.get(name, self.params.get(name.removeprefix(TRAINED)))


@dataclass(frozen=True)
class FinishedRuns:
    """The finished runs of an experiment, oldest first, the number of unfinished ones, and the experiment's id."""

    runs: list[Run]
    unfinished: int
    id: str


class Store:
    """An MLflow tracking store. ``folder`` receives the downloaded artifacts.

    Raises `UserError` if there is no store at ``tracking_uri``, or it cannot be read.

    ``problems`` holds, by a run's id, what of the run could not be read and why; the run counts as without it.
    """

    def __init__(self, tracking_uri: object, folder: Path) -> None:
        # An unreachable server must be reported in seconds; MLflow itself waits for minutes.
        os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "1")
        os.environ.setdefault("MLFLOW_HTTP_REQUEST_TIMEOUT", "20")
        os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
        self._client, self.location = open_client(tracking_uri, write=False)
        self.folder = folder
        self.problems: dict[str, str] = {}

    def experiment(self, name: str, kinds: Sequence[Kind] = ("job",)) -> FinishedRuns:
        """Return the finished runs of an experiment; of several runs with the same identity only the newest.

        An evaluation has no identity: each of them counts.

        Raises:
            UserError: the store cannot be read, or has no such experiment or no finished run; the experiment or its
                files were deleted.
        """
        experiment = find_experiment(self._client, self.location, name)
        if experiment is None:
            raise UserError(
                f"The MLflow store {self.location} has no experiment {name}: train first, or set experiment_name."
            )
        finished, unfinished = self._jobs(experiment.experiment_id, kinds)
        if not finished:
            raise UserError(
                f"The experiment {name} at {self.location} has no finished run, and {unfinished} unfinished ones: "
                "train first."
            )
        check_artifacts(self.location, experiment)
        newest = {run.identity: run for run in sorted(finished, key=lambda run: (run.ended, run.id))}
        return FinishedRuns(list(newest.values()), unfinished, experiment.experiment_id)

    def _jobs(self, experiment_id: str, kinds: Sequence[Kind]) -> tuple[list[Run], int]:
        """Return the finished runs of these kinds, read page by page, and the number of unfinished ones."""
        finished: list[Run] = []
        unfinished = 0
        for kind in kinds:
            token = None
            while True:
                page = self._client.search_runs(
                    [experiment_id], tags.equals(tags.KIND, kind), max_results=PAGE, page_token=token
                )
                jobs = [job for job in page if tags.SEARCH not in job.data.tags]
                done = [_run(job) for job in jobs if job.info.status == FINISHED]
                finished.extend(done)
                unfinished += len(jobs) - len(done)
                token = page.token
                if not token:
                    break
        return finished, unfinished

    def tables(self, runs: Sequence[Run], level: Literal["frames", "clips"]) -> dict[str, pd.DataFrame]:
        """Return the scores of each run by the run's id, one row per frame or clip; a run without scores is left out.

        Runs of earlier versions have JSON tables only; of a table that was logged twice (by a job that was continued),
        the last row of each scene, clip and frame counts.

        Raises:
            UserError: the store gave no run's clips.
        """
        files = self._download(runs, scores.FILE)
        older = self._download([run for run in runs if run.id not in files], f"{level}.json")
        tables: dict[str, pd.DataFrame] = {}
        for run_id, path in {**files, **older}.items():
            try:
                parquet = run_id in files
                tables[run_id] = getattr(scores.read_scores(path), level) if parquet else _read_table(path)
            except (UserError, ValueError, KeyError, TypeError) as error:
                self.note(run_id, f"{path.name} cannot be read ({first_line(error)})")
            if path.is_relative_to(self.folder):  # a copy
                path.unlink()
        if level == "clips" and runs and all(run.id in self.problems for run in runs) and not tables:
            reason = min(self.problems[run.id] for run in runs)
            raise UserError(f"The MLflow store {self.location} gave no run's scores ({reason}): try again.")
        for run in runs:
            if run.id not in tables and run.id not in self.problems:
                self.note(run.id, f"it has no table of its {level}")
        return tables

    def note(self, run_id: str, problem: str) -> None:
        """Add to a run's `problems`."""
        known = self.problems.get(run_id, "")
        if problem not in known:
            self.problems[run_id] = f"{known}; {problem}" if known else problem

    def logged(self, experiment_id: str, kind: Kind, name: str) -> list[tuple[Run, pd.DataFrame]]:
        """Return a table that runs logged by MLflow's ``log_table``, for each finished run of that kind, oldest
        first."""
        runs = sorted(self._jobs(experiment_id, [kind])[0], key=lambda run: (run.ended, run.id))
        files, tables = self._download(runs, name), []
        for run in [run for run in runs if run.id in files]:
            try:
                raw: dict[str, Any] = json.loads(files[run.id].read_text(encoding="utf-8"))
                tables.append((run, pd.DataFrame(raw["data"], columns=raw["columns"])))
            except (ValueError, KeyError, TypeError) as error:
                self.note(run.id, f"{name} cannot be read ({first_line(error)})")
        return tables

    def folders(self, runs: Sequence[Run], name: str) -> dict[str, Path]:
        """Return local copies of an artifact by the run's id; a run without the artifact is left out."""
        return self._download(runs, name)

    def _download(self, runs: Sequence[Run], name: str) -> dict[str, Path]:
        def fetch(run: Run) -> Path | None:
            if name not in {artifact.path for artifact in self._client.list_artifacts(run.id)}:
                return None
            target = self.folder / run.id
            target.mkdir(parents=True, exist_ok=True)
            return Path(self._client.download_artifacts(run.id, name, str(target)))

        def attempt(run: Run) -> Path | None:
            try:
                return fetch(run)
            except (UserError, MlflowException, OSError) as error:
                failed[run.id] = f"{name} could not be downloaded ({first_line(error)})"
                return None

        failed: dict[str, str] = {}
        with ThreadPoolExecutor(DOWNLOADS_AT_ONCE) as pool:
            paths = list(pool.map(attempt, runs))
        for run_id, reason in failed.items():
            self.note(run_id, reason)
        return {run.id: path for run, path in zip(runs, paths) if path is not None}

    def history(self, run: Run, metric: str) -> list[tuple[int, float]]:
        """Return ``(step, value)`` of a metric logged per epoch, by step; empty if the store does not give it."""
        try:
            points = self._client.get_metric_history(run.id, metric)
        except (UserError, MlflowException, OSError) as error:
            self.note(run.id, f"{metric} by step could not be read ({first_line(error)})")
            return []
        return sorted({point.step: point.value for point in points}.items())


def _run(job: MlflowRun) -> Run:
    run_tags, params = job.data.tags, dict(job.data.params)
    kind: Kind = run_tags[tags.KIND]  # type: ignore[assignment]
    if kind == "evaluation" and SCENES not in params:
        # Of an earlier version: they are the training's; of the scored data only the fingerprint is known.
        params = {name: value for name, value in params.items() if name not in ("data", "data.scenes")}
    return Run(
        id=job.info.run_id,
        name=job.info.run_name or job.info.run_id[:8],
        identity=run_tags.get(tags.IDENTITY, job.info.run_id),
        dataset=run_tags.get(tags.DATASET, "unknown"),
        method=run_tags.get(tags.METHOD, params.get("model", "unknown")),
        machine=run_tags.get(tags.MACHINE, "unknown"),
        version=run_tags.get(tags.VERSION, "unknown"),
        ended=job.info.end_time or 0,
        params={sys.intern(k): sys.intern(v) for k, v in params.items()},
        # Averages of single scenes are in the clip tables.
        metrics={sys.intern(k): v for k, v in job.data.metrics.items() if not _SCENE_MEAN.fullmatch(k)},
        kind=kind,
    )


def _read_table(path: Path) -> pd.DataFrame:
    raw: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    table = pd.DataFrame(raw["data"], columns=raw["columns"])
    keys = [key for key in ("scene", "clip", "frame") if key in table]
    return table.drop_duplicates(keys, keep="last").sort_values(keys).reset_index(drop=True)
