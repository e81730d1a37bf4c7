"""The method that a command is about: of a checkpoint, of an MLflow run, or of the configuration itself."""

from collections.abc import Mapping
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

    ``config`` is the model's configuration as `supersampling.runs.options.described` writes it.
    """

    model: Upsampler
    name: str
    config: Mapping[str, Any]
    parameters: Mapping[str, Any]
    origin: Mapping[str, str] = field(default_factory=dict)


def method_of(cfg: DictConfig) -> LoadedMethod:
    """Return the method that ``checkpoint``, ``run`` or ``model`` names; ``cfg.task`` becomes the task it was trained
    for.

    Raises:
        UserError: no such run or checkpoint; the command line names another model or scale; a learned method without
            weights.
    """
    if cfg.run:
        return _method_of_run(experiment_of(cfg), cfg)
    if cfg.checkpoint:
        return _method_of_checkpoint(cfg)
    model: Upsampler = instantiate(cfg.model)
    if is_learned(model):
        raise UserError("This method is learned: name its weights with checkpoint=FILE or run=RUN_ID.")
    return _configured_method(cfg, model)


def _configured_method(cfg: DictConfig, model: Upsampler) -> LoadedMethod:
    config = described(OmegaConf.to_container(cfg.model, resolve=True))
    return LoadedMethod(model, method_name(choices()), config, flat_parameters(cfg, choices(), False))


def _method_of_checkpoint(cfg: DictConfig) -> LoadedMethod:
    path = Path(cfg.checkpoint)
    metadata = read_metadata(path)
    if metadata is None:  # written before checkpoints held their model: it is the configured one
        model: Upsampler = instantiate(cfg.model)
        load_weights(model, path)
        return _configured_method(cfg, model)
    model = _matching_model(cfg, metadata["model"], metadata["task"], str(path))
    load_weights(model, path)
    origin = {key: str(metadata.get(key, "")) for key in ("run", "identity", "version")}
    parameters = dict(metadata.get("parameters", {}))
    return LoadedMethod(model, str(metadata.get("method", "")), described(metadata["model"]), parameters, origin)


def _method_of_run(experiment: Experiment, cfg: DictConfig) -> LoadedMethod:
    """Return the method of a finished run, with its weights or its tuned constants."""
    run = experiment.run(str(cfg.run))
    logged: Any = OmegaConf.to_container(read_configuration(experiment.required_artifact(run, CONFIGURATION)))
    model = _matching_model(cfg, logged["model"], logged["task"], f"Run {cfg.run}", **tuned_constants(run))
    if is_learned(model):
        load_weights(model, experiment.required_artifact(run, CHECKPOINT))
    run_tags = run.data.tags
    origin = {
        "run": str(cfg.run),
        "identity": run_tags.get(tags.IDENTITY, ""),
        "version": run_tags.get(tags.VERSION, ""),
    }
    return LoadedMethod(model, run_tags.get(tags.METHOD, ""), described(logged["model"]), dict(run.data.params), origin)


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


def _matching_model(
    cfg: DictConfig, model: dict[str, Any], task: dict[str, Any], source: str, **constants: float
) -> Upsampler:
    """Build the model of a file's configuration unless the command line contradicts it; ``cfg.task`` becomes its task.

    A model that the command line names as well is built from the command line: its author is trusted with any class.
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
    if not any(key == "model" or key.startswith(("model.", "model/")) for key in typed):
        return build(model, source, **constants)
    stored, configured = described(model), described(OmegaConf.to_container(cfg.model, resolve=True))
    if stored != configured:
        first, second = _difference(stored, configured)
        raise UserError(
            f"{source} holds {first}, but the command line has {second}: leave model=... out, the file knows its own."
        )
    result: Upsampler = instantiate(cfg.model, **constants)
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
