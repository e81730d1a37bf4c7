"""The MLflow experiment that runs are written to: a parent run per multirun, a child run per job, found again by
identity."""

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from mlflow.artifacts import download_artifacts
from mlflow.entities import Run
from mlflow.exceptions import MlflowException
from omegaconf import DictConfig

from supersampling import __version__
from supersampling.errors import UserError
from supersampling.runs import tags
from supersampling.runs.identity import Identity
from supersampling.runs.location import Location
from supersampling.runs.reach import (
    Client,
    check_artifacts,
    explained,
    find_experiment,
    find_run,
    open_client,
    select_store,
)

PARENT_VARIABLE = "SUPERSAMPLING_PARENT_RUN"
FINISHED = "FINISHED"


def machine() -> str:
    """Return the processor's kind, the cores that torch may use, and the accelerator if there is one."""
    device = torch.cuda.get_device_name() if torch.cuda.is_available() else f"{torch.get_num_threads()} threads"
    return f"{platform.system()} {platform.machine()}, {device}, torch {torch.__version__}"


@dataclass(frozen=True)
class Experiment:
    """An MLflow experiment that can be reached; `open_experiment` makes one."""

    client: Client
    id: str
    location: Location

    @property
    def tracking_uri(self) -> str:
        """The URI that MLflow opens."""
        return self.location.uri

    def find(self, identity: Identity | str) -> Run | None:
        """Return the finished run of an identity of either scheme, else its newest unfinished one, else None."""
        keys = (identity,) if isinstance(identity, str) else (identity.key, identity.former)
        runs = [run for key in keys for run in self._runs_of(key)]
        finished = [run for run in runs if run.info.status == FINISHED]
        return next(iter([*finished, *runs]), None)

    def run(self, run_id: str) -> Run:
        """Return a run of the store by its id; raises `UserError` if there is none, or it was deleted."""
        return find_run(self.client, self.location, run_id)

    def _runs_of(self, key: str) -> list[Run]:
        return list(self.client.search_runs([self.id], tags.equals(tags.IDENTITY, key), order_by=["start_time DESC"]))

    def start(self, name: str, run_tags: Mapping[str, str], parent: str | None) -> str:
        """Begin a run and return its id."""
        all_tags = {tags.MACHINE: machine(), tags.VERSION: __version__, **run_tags}
        if parent:
            all_tags[tags.PARENT] = parent
        return self.client.create_run(self.id, run_name=name, tags=all_tags).info.run_id

    def restart(self, run_id: str, parent: str | None) -> None:
        """Continue an unfinished run."""
        self.client.update_run(run_id, status="RUNNING")
        if parent:
            self.client.set_tag(run_id, tags.PARENT, parent)

    def log_params(self, run_id: str, params: Mapping[str, Any]) -> None:
        """Log the parameters that the run does not have yet."""
        known = self.client.get_run(run_id).data.params
        for key, value in params.items():
            if key not in known:
                self.client.log_param(run_id, key, value)

    def log_metrics(self, run_id: str, metrics: Mapping[str, float]) -> None:
        for key, value in metrics.items():
            self.client.log_metric(run_id, key, value)

    def artifact(self, run_id: str, path: str) -> Path:
        """Return a local copy of an artifact; raises `MlflowException` or `OSError` if there is none."""
        with explained(self.location):
            return Path(download_artifacts(run_id=run_id, artifact_path=path, tracking_uri=self.tracking_uri))

    def required_artifact(self, run: Run, path: str) -> Path:
        """Return a local copy of an artifact of a trained method's run; raises `UserError` if the run has none."""
        try:
            return self.artifact(run.info.run_id, path)
        except (MlflowException, OSError) as error:
            raise UserError(f"Run {run.info.run_id} has no {path}{self._reason(run)}.") from error

    def _reason(self, run: Run) -> str:
        files = ", ".join(file.path for file in self.client.list_artifacts(run.info.run_id))
        if tags.KIND not in run.data.tags:
            return ", for another program logged it: name a run of train.py"
        if run.data.tags[tags.KIND] != "job":
            return f", for it is of kind {run.data.tags[tags.KIND]}: name a run of train.py"
        if run.info.status != FINISHED:
            return f", for its status is {run.info.status}: repeat its train.py command, which continues it"
        if files:
            return f" among its files ({files}): name a run of train.py"
        return f": bring its files back to {run.info.artifact_uri}, or train it again with fresh=true"

    def finish(self, run_id: str, status: str = FINISHED) -> None:
        self.client.set_terminated(run_id, status)


def experiment_of(cfg: DictConfig) -> Experiment:
    """Open the MLflow experiment that a configuration names."""
    return open_experiment(cfg.tracking_uri, str(cfg.experiment_name), Path(cfg.paths.artifacts))


def open_experiment(tracking_uri: object, name: str, artifacts: Path) -> Experiment:
    """Return the experiment called ``name``; it is created if it does not exist.

    Args:
        artifacts: the folder in which a local store keeps its files.

    Raises:
        UserError: there is no such store, it cannot be used, or the experiment was deleted.
    """
    client, location = open_client(tracking_uri, write=True)
    select_store(location)
    existing = find_experiment(client, location, name)
    if existing is not None:
        check_artifacts(location, existing, artifacts)
        return Experiment(client, existing.experiment_id, location)
    folder = None if location.is_server else artifacts.resolve().as_uri()
    try:
        return Experiment(client, client.create_experiment(name, artifact_location=folder), location)
    except MlflowException as error:
        created = find_experiment(client, location, name)  # by another process meanwhile
        if created is None:
            raise UserError(f"MLflow cannot create experiment_name={name} at {location} ({error}).") from error
        return Experiment(client, created.experiment_id, location)
