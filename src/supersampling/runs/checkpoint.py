"""The metadata of a checkpoint, with which it needs nothing else, and the method that is built from it.

Whoever wrote a file decides what is built; so a file can only name options of ``conf/`` (`supersampling.runs.options`).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import lightning as L
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling import __version__
from supersampling.errors import UserError, first_line
from supersampling.models.base import Upsampler
from supersampling.runs import tags
from supersampling.runs.checkpoint_file import load_checkpoint
from supersampling.runs.options import described, restored

KEY = "supersampling"  # of the entry in a checkpoint
PREFIX = "model."  # of the model's weights in Lightning's state dict


class Carry(L.Callback):
    """Writes ``metadata`` into every checkpoint, under `KEY`."""

    def __init__(self, metadata: Mapping[str, Any]) -> None:
        self._metadata = dict(metadata)

    def on_save_checkpoint(self, trainer: L.Trainer, pl_module: L.LightningModule, checkpoint: dict[str, Any]) -> None:
        checkpoint[KEY] = self._metadata


def metadata(cfg: DictConfig, run_tags: Mapping[str, str], parameters: Mapping[str, str], run: str) -> dict[str, Any]:
    """Return what a checkpoint holds beside its weights, in containers that ``torch.load(weights_only=True)`` reads.

    ``model`` and ``task`` are the resolved configuration, with options in place of class paths; ``method``,
    ``identity``, ``run`` and ``parameters`` are those of the MLflow run; ``version`` is this package's.
    """
    return {
        "version": __version__,
        "method": str(run_tags.get(tags.METHOD, "")),
        "identity": str(run_tags.get(tags.IDENTITY, "")),
        "run": run,
        "parameters": {str(k): str(v) for k, v in parameters.items()},
        "task": OmegaConf.to_container(cfg.task, resolve=True),
        "model": described(OmegaConf.to_container(cfg.model, resolve=True)),
    }


def read_metadata(checkpoint: Path) -> dict[str, Any] | None:
    """Return what a checkpoint holds beside its weights, None for one that was written before they held anything.

    No code of the file is run.

    Raises:
        UserError: the file is missing or damaged, or is not a checkpoint.
    """
    entry = load_checkpoint(checkpoint).get(KEY)
    if entry is None:
        return None
    if not isinstance(entry, dict) or not all(isinstance(entry.get(k), dict) for k in ("model", "task")):
        raise UserError(f"The configuration in {checkpoint} is broken: name the file that train.py wrote.")
    return entry


def build(model: Mapping[str, Any], source: str, **constants: float) -> Upsampler:
    """Build the method that a file describes.

    Args:
        model: its resolved configuration, with options or, as the first scheme wrote it, class paths.
        source: the file, for messages.
        constants: tuned numbers that replace those of ``model``.

    Raises:
        UserError: it names something that is not among the options of ``conf/``, or that this version cannot build.
    """
    config = restored(dict(model), source)
    try:
        result = instantiate(config, **constants)
    except InstantiationException as error:
        reason = first_line(error)
        raise UserError(
            f"{source} describes a model that this version ({__version__}) cannot build ({reason}): use the version "
            "that "
            "wrote it."
        ) from error
    if not isinstance(result, Upsampler):
        raise UserError(f"{source} describes a {type(result).__name__}, not a method: name a file of train.py.")
    return result


def trained_state(checkpoint: Path) -> dict[str, Any]:
    """Return the weights of a training checkpoint by name (safe loading; no code is run).

    Raises:
        UserError: the file is missing or damaged, or is not a checkpoint.
    """
    weights = load_checkpoint(checkpoint)["state_dict"]
    return {name.removeprefix(PREFIX): value for name, value in weights.items() if name.startswith(PREFIX)}


def load_weights(model: Upsampler, checkpoint: Path) -> None:
    """Load the weights of a training checkpoint into ``model`` (safe loading; no code is run).

    Raises:
        UserError: the file is missing or damaged, is not a checkpoint, or holds another model.
    """
    try:
        model.load_state_dict(trained_state(checkpoint))
    except RuntimeError as error:
        reason = first_line(error)
        raise UserError(
            f"{checkpoint} does not hold weights of the configured model ({reason}): set model=... as it was trained."
        ) from error
