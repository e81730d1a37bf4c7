"""The method that a command is about: of a checkpoint, of an MLflow run, or of the configuration itself."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf, open_dict
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from supersampling.config import choices, key_of, typed_overrides
from supersampling.errors import UserError, describe_system_error
from supersampling.models.base import Upsampler
from supersampling.runs import tags
from supersampling.runs.checkpoint import build, load_weights, read_metadata
from supersampling.runs.exchange import exchange_of
from supersampling.runs.experiment import Experiment, experiment_of
from supersampling.runs.identity import flat_parameters
from supersampling.runs.naming import is_learned, method_name
from supersampling.runs.options import OPTION, described
from supersampling.runs.scores import tuned_constants

CHECKPOINT = "checkpoint/last.ckpt"
CONFIGURATION = "config.yaml"


@dataclass(frozen=True)
class LoadedMethod:
    """A model with its weights, its name and parameters as MLflow shows them, and the run that it came from, if any.

    ``config`` is the model's configuration as `supersampling.runs.options.described` writes it, and ``training`` the
    parameters of the training; they differ from the model's own if stages were exchanged.
    """

    model: Upsampler
    name: str
    config: Mapping[str, Any]
    parameters: Mapping[str, Any]
    origin: Mapping[str, str] = field(default_factory=dict)
    training: Mapping[str, Any] | None = None


def method_of(cfg: DictConfig, exchange: bool = False) -> LoadedMethod:
    """Return the method that ``checkpoint``, ``run`` or ``model`` names; ``cfg.task`` becomes the task it was trained
    for.

    Args:
        exchange: whether parts of a model that the command line names (``model/reproject=bilinear``) replace those
            that it was trained with.

    Raises:
        UserError: no such run or checkpoint; the command line names another model or scale; weights that do not fit
            an exchanged model; a learned method without weights.
    """
    if cfg.run:
        return _method_of_run(experiment_of(cfg), cfg, exchange)
    if cfg.checkpoint:
        return _method_of_checkpoint(cfg, exchange)
    model: Upsampler = instantiate(cfg.model)
    if is_learned(model):
        raise UserError("This method is learned: name its weights with checkpoint=FILE or run=RUN_ID.")
    return _configured_method(cfg, model)


def _configured_method(cfg: DictConfig, model: Upsampler) -> LoadedMethod:
    config = described(OmegaConf.to_container(cfg.model, resolve=True))
    return LoadedMethod(model, method_name(choices()), config, flat_parameters(cfg, choices(), False))


def _method_of_checkpoint(cfg: DictConfig, exchange: bool) -> LoadedMethod:
    path = Path(cfg.checkpoint)
    metadata = read_metadata(path)
    if metadata is None:  # written before checkpoints held their model: it is the configured one
        model: Upsampler = instantiate(cfg.model)
        load_weights(model, path)
        return _configured_method(cfg, model)
    origin = {key: str(metadata.get(key, "")) for key in ("run", "identity", "version")}
    stored = _Stored(
        source=str(path),
        model=metadata["model"],
        task=metadata["task"],
        name=str(metadata.get("method", "")),
        parameters=dict(metadata.get("parameters", {})),
        origin=origin,
    )
    return _load(cfg, stored, lambda: path, exchange)


def _method_of_run(experiment: Experiment, cfg: DictConfig, exchange: bool) -> LoadedMethod:
    """Return the method of a finished run, with its weights or its tuned constants."""
    run = experiment.run(str(cfg.run))
    logged: Any = OmegaConf.to_container(read_configuration(experiment.required_artifact(run, CONFIGURATION)))
    run_tags = run.data.tags
    origin = {
        "run": str(cfg.run),
        "identity": run_tags.get(tags.IDENTITY, ""),
        "version": run_tags.get(tags.VERSION, ""),
    }
    stored = _Stored(
        source=f"Run {cfg.run}",
        model=logged["model"],
        task=logged["task"],
        name=run_tags.get(tags.METHOD, ""),
        parameters=dict(run.data.params),
        origin=origin,
        constants=tuned_constants(run),
    )
    return _load(cfg, stored, lambda: experiment.required_artifact(run, CHECKPOINT), exchange)


@dataclass(frozen=True, kw_only=True)
class _Stored:
    """A method as a checkpoint or a run holds it; ``source`` names that in messages."""

    source: str
    model: Mapping[str, Any]
    task: Mapping[str, Any]
    name: str
    parameters: Mapping[str, Any]
    origin: Mapping[str, str]
    constants: Mapping[str, float] = field(default_factory=dict)


def _load(cfg: DictConfig, stored: _Stored, checkpoint: Callable[[], Path], exchange: bool) -> LoadedMethod:
    """Return the stored method with its weights, exchanged parts included if ``exchange`` allows them."""
    _adopt_task(cfg, stored.task, stored.source)
    replaced = exchange_of(cfg, stored.model, stored.source) if exchange else None
    if replaced is None:
        model = _matching_model(cfg, stored)
        if is_learned(model):
            load_weights(model, checkpoint())
        config, name, parameters = stored.model, stored.name, stored.parameters
    else:
        model = replaced.build(stored.source, **stored.constants)
        if is_learned(model):
            replaced.load_weights(model, checkpoint(), stored.source)
        config, name = replaced.config, replaced.name(stored.name)
        parameters = replaced.parameters(cfg, stored.parameters)
    return LoadedMethod(model, name, described(config), parameters, stored.origin, stored.parameters)


def read_configuration(path: Path) -> DictConfig:
    """Return the configuration that a run logged.

    Raises:
        UserError: the file is damaged, or is no configuration of a method.
    """
    try:
        cfg: Any = OmegaConf.load(path)
        complete = isinstance(cfg, DictConfig) and all(OmegaConf.select(cfg, key) for key in ("model", "task.scale"))
    except (YAMLError, OmegaConfBaseException, ValueError, OSError) as error:
        if isinstance(error, OSError) and (condition := describe_system_error(error, path)):
            raise condition from error
        complete = False
    if not complete:
        raise UserError(f"{path} is truncated or no configuration of a method: restore it, or name a run of train.py.")
    return cfg


def _adopt_task(cfg: DictConfig, task: Mapping[str, Any], source: str) -> None:
    """Set what the command line does not say of ``cfg.task`` to the task of a stored method.

    Raises:
        UserError: the command line says another scale.
    """
    typed = [key_of(override) for override in typed_overrides()]
    task_selected = "task" in typed or "task.scale" in typed or _has_task_of_data()
    if task_selected and cfg.task.scale != task["scale"]:
        raise UserError(
            f"{source} was trained for scale {task['scale']}, but task.scale={cfg.task.scale}: leave it out, or set "
            f"task.scale={task['scale']}."
        )
    with open_dict(cfg):
        for key, value in task.items():
            if not task_selected and f"task.{key}" not in typed:
                cfg.task[key] = value


def _matching_model(cfg: DictConfig, stored: _Stored) -> Upsampler:
    """Build the stored model unless the command line contradicts it.

    A model that the command line names as well is built from the command line: its author is trusted with any class.
    """
    typed = [key_of(override) for override in typed_overrides()]
    if not any(key == "model" or key.startswith(("model.", "model/")) for key in typed):
        return build(stored.model, stored.source, **stored.constants)
    known, configured = described(stored.model), described(OmegaConf.to_container(cfg.model, resolve=True))
    if known != configured:
        first, second = _difference(known, configured)
        raise UserError(
            f"{stored.source} holds {first}, but the command line has {second}: leave model=... out, the file knows "
            "its own."
        )
    result: Upsampler = instantiate(cfg.model, **stored.constants)
    return result


def _has_task_of_data() -> bool:
    """Return whether the selected data set brings a task of its own."""
    return bool(typed_overrides()) and choices().get("task", "default") != "default"


def _difference(first: Any, second: Any, path: str = "model") -> tuple[str, str]:
    """Return the first entry that two configurations do not share, as ``key=value`` of each."""
    if isinstance(first, dict) and isinstance(second, dict):
        for key in (OPTION, *sorted(map(str, first.keys() | second.keys()))):
            if first.get(key) != second.get(key):
                return _difference(first.get(key), second.get(key), f"{path}.{key}")
    if path.endswith(f".{OPTION}"):
        return str(first), str(second)
    return f"{path}={first}", f"{path}={second}"
