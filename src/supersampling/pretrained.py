"""Pretrained weights from torchvision, which downloads each file once."""

from typing import Any

import torch
from torch import nn
from torchvision.models import get_model_weights

from supersampling.errors import UserError


def load_pretrained(module: nn.Module, model: str, weights: str, user: str, alternative: str, prefix: str = "") -> Any:
    """Load the whole ``module`` from torchvision's weights; files are read as tensors only, no code in them is run.

    Args:
        module: its names are those of torchvision's ``model`` that begin with ``prefix``, without the prefix.
        model: a model name of torchvision, e.g. ``vgg16``.
        weights: a name of weights of this model.
        user: subject of the error message, e.g. "The perceptual loss".
        alternative: imperative that ends the error message, e.g. "remove the term".
        prefix: beginning of the names to load.

    Returns:
        torchvision's entry of the weights, which describes the inputs that they require.

    Raises:
        UserError: the weights do not exist or cannot be loaded; the message says which file to put where.
    """
    known: dict[str, Any] = {entry.name: entry for entry in get_model_weights(model)}
    if weights not in known:
        raise UserError(f"Unknown weights {weights} of torchvision's {model}: use one of {', '.join(known)}.")
    entry = known[weights]
    try:
        state = entry.get_state_dict(progress=False, check_hash=True, weights_only=True, map_location="cpu")
        module.load_state_dict({k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)})
    except Exception as error:  # a corrupt file can raise any exception
        path = f"{torch.hub.get_dir()}/checkpoints/{entry.url.rsplit('/', 1)[-1]}"
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise UserError(
            f"{user} needs the weights of {model}, which could not be loaded ({reason}): put the file {entry.url} at "
            f"{path}, or {alternative}."
        ) from error
    return entry
