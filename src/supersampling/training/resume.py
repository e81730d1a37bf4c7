"""The checkpoint from which an interrupted training continues."""

from pathlib import Path
from typing import Any

import lightning as L

from supersampling.errors import DamagedFile, UserError
from supersampling.files import set_aside
from supersampling.runs.checkpoint_file import load_checkpoint

PARTS = ("epoch", "global_step", "loops", "optimizer_states", "lr_schedulers")  # that Lightning continues from
START_OVER = "move it to another folder, then the same command trains from the beginning"


def resume_checkpoint(path: Path, module: L.LightningModule) -> Path | None:
    """Return the checkpoint ``path`` if a training can continue from it, None if it does not exist.

    A broken one, as a full disk or a crash leaves, is renamed: the training then begins anew.

    Raises:
        UserError: the file is whole but no checkpoint of this training.
    """
    if not path.exists():
        return None
    try:
        content = load_checkpoint(path)
    except DamagedFile as error:
        set_aside(path, error, "the training begins anew")
        return None
    missing = [part for part in PARTS if part not in content]
    if missing:
        raise UserError(f"{path} is not a checkpoint of a training (it has no {missing[0]}): {START_OVER}.")
    difference = _difference(content["state_dict"], module.state_dict())
    if difference:
        raise UserError(f"{path} holds the weights of another model ({difference}): {START_OVER}.")
    return path


def _difference(stored: dict[str, Any], expected: dict[str, Any]) -> str:
    """Return the first weight that differs in name or shape; an empty string if none does."""
    for name in sorted(stored.keys() | expected.keys()):
        first, second = (list(weights[name].shape) if name in weights else "none" for weights in (stored, expected))
        if first != second:
            return f"{name} is {first} instead of {second}"
    return ""
