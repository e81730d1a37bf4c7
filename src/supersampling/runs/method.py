"""The method that a command is about: of a checkpoint, of an MLflow run, or of the configuration alone."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from mlflow.exceptions import MlflowException
from omegaconf import DictConfig, OmegaConf, open_dict

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.runs.checkpoint import build, carried, load_weights
from supersampling.runs.experiment import Experiment, experiment_of
from supersampling.runs.identity import flat_parameters
from supersampling.runs.naming import is_learned, method_name
from supersampling.runs.scores import tuned_constants


@dataclass(frozen=True)
class Method:
    """A model with its weights, its name and parameters as MLflow shows them, and which run it came from, if any."""

    model: Upsampler
    name: str
    parameters: Mapping[str, Any]
    origin: Mapping[str, str] = field(default_factory=dict)


def method_of(cfg: DictConfig) -> Method:
    """What ``checkpoint``, ``run`` or ``model`` of a configuration name; ``cfg.task`` becomes the one that it was trained for.

    Raises:
        UserError: no such run or checkpoint; a model or scale on the command line that is another; a learned method
            without weights.
    """
    if cfg.run:
        return _of_run(experiment_of(cfg), cfg)
    if cfg.checkpoint:
        return _of_checkpoint(cfg)
    model: Upsampler = instantiate(cfg.model)
    if is_learned(model):
        raise UserError("This method is learned: give its weights with checkpoint=FILE or run=RUN_ID.")
    return _configured(cfg, model)


def _configured(cfg: DictConfig, model: Upsampler) -> Method:
    choices = dict(HydraConfig.get().runtime.choices)
    return Method(model, method_name(choices), flat_parameters(cfg, choices, False))


def _of_checkpoint(cfg: DictConfig) -> Method:
    path = Path(cfg.checkpoint)
    said = carried(path)
    if said is None:  # an older one: its model is the configured one
        model: Upsampler = instantiate(cfg.model)
        load_weights(model, path)
        return _configured(cfg, model)
    model = _agreed(cfg, said["model"], said["task"], str(path))
    load_weights(model, path)
    origin = {key: str(said.get(key, "")) for key in ("run", "identity", "version")}
    return Method(model, str(said.get("method", "")), dict(said.get("parameters", {})), origin)


def _of_run(experiment: Experiment, cfg: DictConfig) -> Method:
    """Of a finished run, with its weights or its tuned constants."""
    try:
        run = experiment.client.get_run(cfg.run)
        trained: Any = OmegaConf.to_container(OmegaConf.load(experiment.artifact(cfg.run, "config.yaml")))
    except (MlflowException, OSError) as error:
        raise UserError(
            f"There is no run {cfg.run} with a result at {experiment.tracking_uri}: see the ids in the MLflow UI."
        ) from error
    model = _agreed(cfg, trained["model"], trained["task"], f"Run {cfg.run}", **tuned_constants(run))
    if is_learned(model):
        load_weights(model, experiment.artifact(cfg.run, "checkpoint/last.ckpt"))
    tags = run.data.tags
    origin = {
        "run": str(cfg.run),
        "identity": tags.get("ss.identity", ""),
        "version": tags.get("ss.version", ""),
    }
    return Method(model, tags.get("ss.method", ""), dict(run.data.params), origin)


def _agreed(cfg: DictConfig, model: dict[str, Any], task: dict[str, Any], source: str, **constants: float) -> Upsampler:
    """The model of a file's configuration, once nothing on the command line speaks against it; ``cfg.task`` becomes its task.

    A model that the command line names as well is made from the command line: its author is trusted with any class.
    """
    given = _given()
    chosen = "task" in given or "task.scale" in given or _by_data()
    if chosen and cfg.task.scale != task["scale"]:
        raise UserError(
            f"{source} was trained for scale {task['scale']}, but task.scale={cfg.task.scale}: leave it out, or set "
            f"task.scale={task['scale']}."
        )
    with open_dict(cfg):
        for key, value in task.items():
            if not chosen and f"task.{key}" not in given:
                cfg.task[key] = value
    if not any(key == "model" or key.startswith(("model.", "model/")) for key in given):
        return build(model, source, **constants)
    named: Any = OmegaConf.to_container(cfg.model, resolve=True)
    if named != model:
        held, wanted = _difference(model, named)
        raise UserError(
            f"{source} holds {held}, but the command line has {wanted}: leave model=... out, the file knows its own."
        )
    made: Upsampler = instantiate(cfg.model, **constants)
    return made


def _given() -> list[str]:
    """The keys and groups that the command line sets."""
    if not HydraConfig.initialized():
        return []
    return [str(o).lstrip("+~").partition("=")[0].partition("@")[0] for o in HydraConfig.get().overrides.task]


def _by_data() -> bool:
    """Whether the chosen data set brings a task of its own."""
    return HydraConfig.initialized() and HydraConfig.get().runtime.choices.get("task", "default") != "default"


def _difference(ours: Any, theirs: Any, path: str = "model") -> tuple[str, str]:
    """The first entry that two configurations do not share, as ``key=value`` of each."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        for key in ("_target_", *sorted(map(str, ours.keys() | theirs.keys()))):
            if ours.get(key) != theirs.get(key):
                return _difference(ours.get(key), theirs.get(key), f"{path}.{key}")
    return tuple(f"{path}={value}".replace("._target_", "") for value in (ours, theirs))  # type: ignore[return-value]
