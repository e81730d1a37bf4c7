"""The MLflow experiment that runs are written to: a parent run per multirun, a child run per job, found again by
identity."""

import os
import platform
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlparse

import mlflow
import requests
import torch
from mlflow.artifacts import download_artifacts
from mlflow.entities import Run
from mlflow.exceptions import MlflowException
from mlflow.tracking import MlflowClient
from omegaconf import DictConfig

from supersampling import __version__
from supersampling.errors import UserError
from supersampling.runs import tags
from supersampling.runs.identity import Identity

PARENT_VARIABLE = "SUPERSAMPLING_PARENT_RUN"
FINISHED = "FINISHED"


def machine() -> str:
    """Return the processor's kind, the cores that torch may use, and the accelerator if there is one."""
    device = torch.cuda.get_device_name() if torch.cuda.is_available() else f"{torch.get_num_threads()} threads"
    return f"{platform.system()} {platform.machine()}, {device}, torch {torch.__version__}"


@dataclass(frozen=True)
class Experiment:
    """An MLflow experiment that can be reached; `open_experiment` makes one."""

    client: MlflowClient
    id: str
    tracking_uri: str

    def find(self, identity: Identity | str) -> Run | None:
        """Return the finished run of an identity of either scheme, else its newest unfinished one, else None."""
        keys = (identity,) if isinstance(identity, str) else (identity.key, identity.former)
        runs = [run for key in keys for run in self._runs_of(key)]
        finished = [run for run in runs if run.info.status == FINISHED]
        return next(iter([*finished, *runs]), None)

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
        return Path(download_artifacts(run_id=run_id, artifact_path=path, tracking_uri=self.tracking_uri))

    def finish(self, run_id: str, status: str = FINISHED) -> None:
        self.client.set_terminated(run_id, status)


def experiment_of(cfg: DictConfig) -> Experiment:
    """Open the MLflow experiment that a configuration names."""
    return open_experiment(cfg.tracking_uri, cfg.experiment_name, Path(cfg.paths.artifacts))


def open_experiment(tracking_uri: str, name: str, artifacts: Path) -> Experiment:
    """Return the experiment called ``name``; it is created if it does not exist.

    Args:
        artifacts: the folder in which a local store keeps its files.

    Raises:
        UserError: the tracking server does not answer.
    """
    _check_reachable(tracking_uri)
    _create_database(tracking_uri)
    mlflow.set_tracking_uri(tracking_uri)
    client = MlflowClient(tracking_uri)
    try:
        existing = client.get_experiment_by_name(name)
        if existing is not None:
            return Experiment(client, existing.experiment_id, tracking_uri)
        location = None if tracking_uri.startswith("http") else artifacts.resolve().as_uri()
        return Experiment(client, client.create_experiment(name, artifact_location=location), tracking_uri)
    except MlflowException as error:
        reason = str(error).splitlines()[0]
        raise UserError(f"MLflow failed at tracking_uri={tracking_uri} ({reason}): check the address.") from error


def _create_database(tracking_uri: str) -> None:
    """Create a missing local database beside its place, then move it there.

    MLflow creates tables one by one; killed half-way, it leaves a database that it can neither use nor repair.
    """
    prefix = "sqlite:///"
    path = Path(tracking_uri.removeprefix(prefix))
    if not tracking_uri.startswith(prefix) or not path.name or path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".new-store-") as folder:
        complete = Path(folder) / path.name
        MlflowClient(f"{prefix}{complete}").search_experiments()
        try:
            os.link(complete, path)
        except FileExistsError:  # another process was first
            pass
        except OSError:  # a file system without links
            os.replace(complete, path)


def _check_reachable(tracking_uri: str) -> None:
    """Ask a server once, so that MLflow's minutes of retries never start."""
    if urlparse(tracking_uri).scheme not in ("http", "https"):
        return
    try:
        requests.get(f"{tracking_uri.rstrip('/')}/health", timeout=5).raise_for_status()
    except requests.RequestException as error:
        raise UserError(
            f"No MLflow server answers at tracking_uri={tracking_uri}: start it, or leave the setting out for the "
            "local store."
        ) from error
