"""Methods by name or by run, for commands that need their configuration and no weights."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hydra.core.hydra_config import HydraConfig
from mlflow.entities import Run
from mlflow.exceptions import MlflowException
from omegaconf import DictConfig, OmegaConf

from supersampling.config import composed, group_options, key_of, published_stages, typed_overrides
from supersampling.errors import UserError
from supersampling.runs import tags
from supersampling.runs.experiment import FINISHED, Experiment
from supersampling.runs.identity import flat_parameters
from supersampling.runs.method import CONFIGURATION, read_configuration
from supersampling.runs.naming import method_name
from supersampling.runs.options import restored
from supersampling.runs.timing import architecture

ALL = "all"


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A method at a scale: its name, resolved configuration and jitter pattern.

    ``parameters`` are those of its model and task, as a run of train.py has them.
    """

    name: str
    model: Mapping[str, Any]
    scale: int
    jitter: str
    parameters: Mapping[str, str] = field(default_factory=dict)

    @property
    def architecture(self) -> str:
        return architecture(self.model, self.scale)


def subjects_by_name(names: Sequence[str], scales: Sequence[int]) -> list[Subject]:
    """Return methods by their names in ``conf/model``, or the composed one if there are no names, at every scale.

    A name may be followed by switches of the model: ``dlctus reproject=bilinear``, ``nsrr previous=2``.

    Raises:
        UserError: there is no such method or switch.
    """
    methods: list[str | None] = [*names] or [None]
    return [_compose_subject(name, scale) for name in methods for scale in scales]


def _compose_subject(name: str | None, scale: int) -> Subject:
    """Return what the command line composes, with another method in place of its own."""
    overrides = [o for o in typed_overrides() if key_of(o) != "task.scale"] + [f"task.scale={scale}"]
    if name is not None:
        overrides = [o for o in overrides if key_of(o).split("/")[0].split(".")[0] != "model"] + _overrides(name)
    composition = composed(HydraConfig.get().job.config_name or "", overrides)
    model: Any = OmegaConf.to_container(composition.cfg.model, resolve=True)
    return Subject(
        name=name or method_name(composition.choices),
        model=model,
        scale=scale,
        jitter=composition.cfg.task.jitter,
        parameters=_parameters(composition.cfg, composition.choices),
    )


def _overrides(name: str) -> list[str]:
    """Return the overrides that compose a method of ``methods``, such as ``nsrr reweight=none previous=2``."""
    model, *switches = name.split()
    known = group_options("model")
    if model not in known:
        raise UserError(f"Unknown method {model} in methods: use {', '.join(known)}.")
    slots = published_stages(model)
    wrong = [switch for switch in switches if "=" not in switch]
    if wrong:
        raise UserError(f"Invalid switch {wrong[0]} of {model} in methods: use slot=option or setting=value.")
    keys = [switch.partition("=")[0] for switch in switches]
    return [f"model={model}", *(f"model{'/' if k in slots else '.'}{s}" for k, s in zip(keys, switches))]


def _parameters(cfg: DictConfig, choices: Mapping[str, Any]) -> dict[str, str]:
    """Return the flat parameters of a composition's model and task."""
    part = OmegaConf.create({"model": cfg.model, "task": cfg.task, "scene": ""})
    selected = {group: option for group, option in choices.items() if group.split("/")[0] in ("model", "task")}
    flat = flat_parameters(part, selected, learned=True)
    return {name: str(value) for name, value in flat.items() if _is_of_method(name)}


def _is_of_method(parameter: str) -> bool:
    return parameter.split(".")[0] in ("model", "task")


def subjects_of_run(experiment: Experiment, run_id: str) -> list[Subject]:
    """Return the method of a run, at its own scale; for ``all``, those of all finished jobs, each once.

    Raises:
        UserError: there is no such run, or it has no configuration.
    """
    return [subject for _, subject in runs_with_subjects(experiment, run_id)]


def runs_with_subjects(experiment: Experiment, run_id: str) -> list[tuple[str, Subject]]:
    """Return the same as `subjects_of_run`, each with its run's id: for ``all`` the newest run of every architecture.

    Raises:
        UserError: there is no such run, or it has no configuration.
    """
    if run_id == ALL:
        newest: dict[str, tuple[str, Subject]] = {}
        for run, subject in finished_jobs(experiment):
            newest.setdefault(subject.architecture, (run, subject))
        if not newest:
            raise UserError(f"There is no finished run at {experiment.location} for run={ALL}: train first.")
        return list(newest.values())
    subject_of_run = _read_subject(experiment, experiment.run(run_id))
    if subject_of_run is None:
        raise UserError(f"Run {run_id} has no {CONFIGURATION} of a method: name a run of train.py.")
    return [(run_id, subject_of_run)]


def finished_jobs(experiment: Experiment) -> Iterator[tuple[str, Subject]]:
    """Yield the id and the method of every finished job whose model this version has, the newest first."""
    jobs = f"{tags.equals(tags.KIND, 'job')} and attributes.status = '{FINISHED}'"
    token = None
    while True:
        page = experiment.client.search_runs(
            [experiment.id], jobs, order_by=["attributes.start_time DESC"], page_token=token
        )
        for run in page:
            try:
                subject = _read_subject(experiment, run)
            except UserError as error:  # a model that this version does not have
                sys.stderr.write(f"Left out: {error}\n")
                continue
            if subject is not None:
                yield run.info.run_id, subject
        token = page.token
        if not token:
            return


def _read_subject(experiment: Experiment, run: Run) -> Subject | None:
    try:
        path = experiment.artifact(run.info.run_id, CONFIGURATION)
    except (MlflowException, OSError):
        return None
    cfg = read_configuration(path)
    model = restored(OmegaConf.to_container(cfg.model, resolve=True), f"Run {run.info.run_id}")
    return Subject(
        name=run.data.tags.get(tags.METHOD, ""),
        model=model,
        scale=cfg.task.scale,
        jitter=cfg.task.get("jitter", "thesis"),
        parameters={name: value for name, value in run.data.params.items() if _is_of_method(name)},
    )
