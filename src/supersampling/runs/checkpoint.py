"""What a checkpoint carries beside its weights, so that it needs nothing else, and how a method is made of what a file says."""

import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import lightning as L
import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling import __version__
from supersampling.errors import UserError
from supersampling.models.base import Upsampler

KEY = "supersampling"  # of a checkpoint
OURS = ("supersampling.models.", "supersampling.stages.")


class Carry(L.Callback):
    """Puts ``content`` into every checkpoint, under `KEY`."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        self._content = dict(content)

    def on_save_checkpoint(self, trainer: L.Trainer, pl_module: L.LightningModule, checkpoint: dict[str, Any]) -> None:
        checkpoint[KEY] = self._content


def content(cfg: DictConfig, tags: Mapping[str, str], parameters: Mapping[str, str], run: str) -> dict[str, Any]:
    """What is carried, in containers that ``torch.load(weights_only=True)`` reads.

    ``model`` and ``task`` are the resolved configuration; ``method``, ``identity``, ``run`` and ``parameters`` those of the
    MLflow run, whose ``tags`` and ``parameters`` are given; ``version`` is this package's.
    """
    return {
        "version": __version__,
        "method": str(tags.get("ss.method", "")),
        "identity": str(tags.get("ss.identity", "")),
        "run": run,
        "parameters": {str(k): str(v) for k, v in parameters.items()},
        "task": OmegaConf.to_container(cfg.task, resolve=True),
        "model": OmegaConf.to_container(cfg.model, resolve=True),
    }


def carried(checkpoint: Path) -> dict[str, Any] | None:
    """What a checkpoint carries; None in one that was written before they carried anything. No code is run.

    Raises:
        UserError: the file is missing, or no checkpoint.
    """
    try:
        found = torch.load(checkpoint, map_location="cpu", weights_only=True, mmap=True)
        said = found.get(KEY)
    except FileNotFoundError as error:
        raise UserError(f"There is no checkpoint {checkpoint}: correct the path.") from error
    except Exception as error:
        reason = str(error).splitlines()[0]
        raise UserError(f"{checkpoint} is not a checkpoint ({reason}): name a file of train.py.") from error
    if said is None:
        return None
    if not isinstance(said, dict) or not all(isinstance(said.get(k), dict) for k in ("model", "task")):
        raise UserError(f"{checkpoint} carries a configuration that is broken: name the file that train.py wrote.")
    return said


def build(model: Mapping[str, Any], source: str, **constants: float) -> Upsampler:
    """The method that a file's configuration describes, resolved; ``source`` is that file, for messages.

    Whoever wrote the file says what is made: so nothing but our own models and stages is, and nothing is interpolated.

    Raises:
        UserError: something else is named, or this version cannot make it.
    """
    _check(model, source)
    try:
        made = instantiate(dict(model), **constants)
    except InstantiationException as error:
        reason = str(error).splitlines()[0]
        raise UserError(
            f"{source} describes a model that this version ({__version__}) cannot make ({reason}): use the version that "
            "wrote it."
        ) from error
    if not isinstance(made, Upsampler):
        raise UserError(f"{source} describes no method: its model is a {type(made).__name__}.")
    return made


def _check(value: Any, source: str) -> None:
    if isinstance(value, Mapping):
        if "_target_" in value and not _is_ours(value["_target_"]):
            raise UserError(
                f"{source} wants {value['_target_']} to be called, which is none of our models and stages, so it is not "
                "loaded: if you trust the file, give model=... as it was trained."
            )
        for inner in (*value.keys(), *value.values()):
            _check(inner, source)
    elif isinstance(value, (list, tuple)):
        for inner in value:
            _check(inner, source)
    elif isinstance(value, str) and "${" in value:
        raise UserError(f"{source} holds the interpolation {value}, so it is not loaded: only values are.")


def _is_ours(target: Any) -> bool:
    """Whether it is a class of our models or stages, not something that only can be reached through their modules."""
    if not isinstance(target, str) or not target.startswith(OURS):
        return False
    module, _, name = target.rpartition(".")
    try:
        found = getattr(importlib.import_module(module), name, None)
    except ImportError:
        return False
    return isinstance(found, type) and f"{found.__module__}.".startswith(OURS)


def load_weights(model: Upsampler, checkpoint: Path) -> None:
    """Load the weights of a training checkpoint into ``model`` (safe loading; no code is run).

    Raises:
        UserError: the file is missing, is no checkpoint, or holds another model.
    """
    try:
        content = torch.load(checkpoint, map_location="cpu", weights_only=True)
        prefix = "model."
        state = {k.removeprefix(prefix): v for k, v in content["state_dict"].items() if k.startswith(prefix)}
        model.load_state_dict(state)
    except FileNotFoundError as error:
        raise UserError(f"There is no checkpoint {checkpoint}: correct the path.") from error
    except Exception as error:
        reason = str(error).splitlines()[0]
        raise UserError(
            f"{checkpoint} does not hold weights of the configured model ({reason}): set model=... as it was trained."
        ) from error
