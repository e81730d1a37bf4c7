"""Which methods a command times."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hydra import compose
from hydra.core.hydra_config import HydraConfig
from hydra.errors import ConfigCompositionException
from mlflow.entities import Run
from mlflow.exceptions import MlflowException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from supersampling.errors import UserError
from supersampling.runs.experiment import Experiment
from supersampling.runs.naming import method_name
from supersampling.runs.timing import architecture

ALL = "all"


@dataclass(frozen=True)
class Subject:
    """A method at a scale: its name, resolved configuration and jitter pattern."""

    name: str
    model: Mapping[str, Any]
    scale: int
    jitter: str

    @property
    def architecture(self) -> str:
        return architecture(self.model, self.scale)


def named(names: Sequence[str], scales: Sequence[int]) -> list[Subject]:
    """Methods by their names in ``conf/model``, or the composed one where there are none, at every scale.

    Raises:
        UserError: there is no such method.
    """
    known = {Path(path).stem for path in _options("model")}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise UserError(f"methods={unknown[0]} is not known: use {', '.join(sorted(known))}.")
    chosen: list[str | None] = [*names] or [None]
    return [_composed(name, scale) for name in chosen for scale in scales]


def _options(group: str) -> list[str]:
    from hydra.core.global_hydra import GlobalHydra

    return GlobalHydra.instance().config_loader().get_group_options(group)


def _composed(name: str | None, scale: int) -> Subject:
    """What the command line composes, with another method's name in place of its own."""
    given = list(HydraConfig.get().overrides.task)
    if name is not None:
        given = [o for o in given if o.split("=")[0].lstrip("+~").split("/")[0].split(".")[0] != "model"]
        given.append(f"model={name}")
    given = [o for o in given if not o.startswith("task.scale=")] + [f"task.scale={scale}"]
    try:
        cfg = compose(HydraConfig.get().job.config_name, given, return_hydra_config=True)
        model: Any = OmegaConf.to_container(cfg.model, resolve=True)
    except (ConfigCompositionException, OmegaConfBaseException) as error:
        raise UserError(f"methods={name} does not go with the other settings: {error}") from error
    return Subject(method_name(cfg.hydra.runtime.choices), model, scale, cfg.task.jitter)


def of_run(experiment: Experiment, run_id: str) -> list[Subject]:
    """The method of a run, at its own scale; of ``all``, those of all finished jobs, each once.

    Raises:
        UserError: there is no such run, or it has no configuration.
    """
    return [subject for _, subject in runs_of(experiment, run_id)]


def runs_of(experiment: Experiment, run_id: str) -> list[tuple[str, Subject]]:
    """As `of_run`, each with its run: of ``all`` the newest of every architecture.

    Raises:
        UserError: there is no such run, or it has no configuration.
    """
    if run_id == ALL:
        found: dict[str, tuple[str, Subject]] = {}
        for run, subject in finished_jobs(experiment):
            found.setdefault(subject.architecture, (run, subject))
        if not found:
            raise UserError(f"run={ALL}: {experiment.tracking_uri} has no finished run: train first.")
        return list(found.values())
    try:
        chosen = _of(experiment, experiment.client.get_run(run_id))
    except MlflowException as error:
        raise UserError(
            f"There is no run {run_id} at {experiment.tracking_uri}: see the ids in the MLflow UI."
        ) from error
    if chosen is None:
        raise UserError(f"Run {run_id} has no config.yaml of a method: give one of train.py's.")
    return [(run_id, chosen)]


def finished_jobs(experiment: Experiment) -> Iterator[tuple[str, Subject]]:
    """The id and the method of every finished job that has a configuration, the newest first."""
    token = None
    while True:
        page = experiment.client.search_runs(
            [experiment.id], "tags.`ss.kind` = 'job' and attributes.status = 'FINISHED'",
            order_by=["attributes.start_time DESC"], page_token=token,
        )  # fmt: skip
        for run in page:
            subject = _of(experiment, run)
            if subject is not None:
                yield run.info.run_id, subject
        token = page.token
        if not token:
            return


def _of(experiment: Experiment, run: Run) -> Subject | None:
    try:
        cfg: Any = OmegaConf.load(experiment.artifact(run.info.run_id, "config.yaml"))
    except (MlflowException, OSError):
        return None
    if not isinstance(cfg, DictConfig) or not all(OmegaConf.select(cfg, k) for k in ("model", "task.scale")):
        return None
    model: Any = OmegaConf.to_container(cfg.model, resolve=True)
    return Subject(run.data.tags.get("ss.method", ""), model, cfg.task.scale, cfg.task.get("jitter", "thesis"))
