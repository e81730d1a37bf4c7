"""Pretrained weights by torchvision's own path, which downloads a file once and reads it from there."""

from typing import Any

import torch
from torch import nn
from torchvision.models import get_model_weights

from supersampling.errors import UserError


def load_pretrained(module: nn.Module, model: str, weights: str, whose: str, otherwise: str, prefix: str = "") -> Any:
    """Load all of ``module`` from torchvision's weights; files are read as tensors alone, no code in them is run.

    Args:
        module: has the names of torchvision's ``model`` that begin with ``prefix``, without it.
        model: a name of torchvision's, as ``vgg16``.
        weights: a name among those for this model.
        whose: who needs them, as a sentence begins; ``otherwise``: what can be done without them. For the message.

    Returns:
        torchvision's entry of the weights, which holds what inputs have to be like.

    Raises:
        UserError: there are no such weights, or they cannot be had; it says which file goes where.
    """
    known: dict[str, Any] = {entry.name: entry for entry in get_model_weights(model)}
    if weights not in known:
        raise UserError(f"torchvision has no weights {weights} of {model}: use one of {', '.join(known)}.")
    entry = known[weights]
    try:
        state = entry.get_state_dict(progress=False, check_hash=True, weights_only=True, map_location="cpu")
        module.load_state_dict({k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)})
    except Exception as error:  # a broken file raises whatever its bytes lead the reader to
        path = f"{torch.hub.get_dir()}/checkpoints/{entry.url.rsplit('/', 1)[-1]}"
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise UserError(
            f"{whose} needs the weights of {model}, which could not be had ({reason}): put the file {entry.url} at {path}, or "
            f"{otherwise}."
        ) from error
    return entry
