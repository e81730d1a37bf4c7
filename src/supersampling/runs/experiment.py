"""MLflow: one experiment, a parent run for each multirun, a child run for each job, found again by identity."""

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

PARENT_VARIABLE = "SUPERSAMPLING_PARENT_RUN"


def machine() -> str:
    """Processor kind, cores torch may use, and the accelerator if there is one."""
    device = torch.cuda.get_device_name() if torch.cuda.is_available() else f"{torch.get_num_threads()} threads"
    return f"{platform.system()} {platform.machine()}, {device}, torch {torch.__version__}"


@dataclass(frozen=True)
class Experiment:
    """An MLflow experiment that is reachable; make one with `open_experiment`."""

    client: MlflowClient
    id: str
    tracking_uri: str

    def find(self, identity: str) -> Run | None:
        """The finished run of an identity, else its newest unfinished one, else None."""
        runs = self.client.search_runs([self.id], f"tags.`ss.identity` = '{identity}'", order_by=["start_time DESC"])
        finished = [run for run in runs if run.info.status == "FINISHED"]
        return finished[0] if finished else (runs[0] if runs else None)

    def start(self, name: str, tags: Mapping[str, str], parent: str | None) -> str:
        """Begin a run and return its id."""
        all_tags = {"ss.machine": machine(), "ss.version": __version__, **tags}
        if parent:
            all_tags["mlflow.parentRunId"] = parent
        return self.client.create_run(self.id, run_name=name, tags=all_tags).info.run_id

    def restart(self, run_id: str, parent: str | None) -> None:
        """Take up an unfinished run again."""
        self.client.update_run(run_id, status="RUNNING")
        if parent:
            self.client.set_tag(run_id, "mlflow.parentRunId", parent)

    def log_params(self, run_id: str, params: Mapping[str, Any]) -> None:
        known = self.client.get_run(run_id).data.params
        for key, value in params.items():
            if key not in known:
                self.client.log_param(run_id, key, value)

    def log_metrics(self, run_id: str, metrics: Mapping[str, float]) -> None:
        for key, value in metrics.items():
            self.client.log_metric(run_id, key, value)

    def artifact(self, run_id: str, path: str) -> Path:
        """A local copy of an artifact; raises `MlflowException` or `OSError` when there is none."""
        return Path(download_artifacts(run_id=run_id, artifact_path=path, tracking_uri=self.tracking_uri))

    def finish(self, run_id: str, status: str = "FINISHED") -> None:
        self.client.set_terminated(run_id, status)


def open_experiment(tracking_uri: str, name: str, artifacts: Path) -> Experiment:
    """The experiment called ``name``, made if it is not there. ``artifacts`` is where a local store keeps its files.

    Raises:
        UserError: the tracking server does not answer.
    """
    _check_reachable(tracking_uri)
    _make_whole(tracking_uri)
    mlflow.set_tracking_uri(tracking_uri)
    client = MlflowClient(tracking_uri)
    try:
        found = client.get_experiment_by_name(name)
        if found is not None:
            return Experiment(client, found.experiment_id, tracking_uri)
        location = None if tracking_uri.startswith("http") else artifacts.resolve().as_uri()
        return Experiment(client, client.create_experiment(name, artifact_location=location), tracking_uri)
    except MlflowException as error:
        raise UserError(f"MLflow at logger.tracking_uri={tracking_uri} failed: {str(error).splitlines()[0]}") from error


def _make_whole(tracking_uri: str) -> None:
    """Make a local database that is not there yet beside its place, then move it there.

    MLflow makes tables one by one; killed half-way it leaves a database that it can neither use nor mend.
    """
    prefix = "sqlite:///"
    path = Path(tracking_uri.removeprefix(prefix))
    if not tracking_uri.startswith(prefix) or not path.name or path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=".new-store-") as folder:
        made = Path(folder) / path.name
        MlflowClient(f"{prefix}{made}").search_experiments()
        try:
            os.link(made, path)
        except FileExistsError:  # another process was first
            pass
        except OSError:  # a file system without links
            os.replace(made, path)


def _check_reachable(tracking_uri: str) -> None:
    """Ask a server once, so that MLflow's minutes of retries never start."""
    if urlparse(tracking_uri).scheme not in ("http", "https"):
        return
    try:
        requests.get(f"{tracking_uri.rstrip('/')}/health", timeout=5).raise_for_status()
    except requests.RequestException as error:
        raise UserError(
            f"No MLflow server answers at logger.tracking_uri={tracking_uri}: start it, or leave the setting "
            "out for the local store."
        ) from error


def experiment_of(cfg: DictConfig) -> Experiment:
    """The MLflow experiment that a configuration names."""
    return open_experiment(cfg.logger.tracking_uri, cfg.logger.experiment, Path(cfg.paths.artifacts))
