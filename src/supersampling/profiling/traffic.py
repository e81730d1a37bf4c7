"""What a frame costs at least, of shapes alone."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from torch import Tensor
from torch.utils._pytree import tree_leaves

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.count import LONGEST, count_modules, random_frame
from supersampling.profiling.backends import buffers


@dataclass(frozen=True)
class Work:
    """Parameters; multiply-accumulates and bytes moved of a frame, NaN where shapes alone do not tell."""

    parameters: int
    macs: float
    bytes: float


def work(config: Mapping[str, Any], width: int, height: int) -> Work:
    """Of a method's configuration and a low-resolution size; all is unknown of what is not possible there."""
    parameters = 0
    try:
        model: Upsampler = instantiate(dict(config))
        parameters = sum(p.numel() for p in model.parameters())
        macs = float(count_modules(model, width, height)[-1].macs)
        return Work(parameters, macs, float(bytes_moved(model, width, height)))
    except (UserError, InstantiationException, RuntimeError, ValueError):
        return Work(parameters, math.nan, math.nan)


@torch.no_grad()
def bytes_moved(model: Upsampler, width: int, height: int) -> int:
    """Bytes that a frame reads and writes at least, once the state has its full size: its inputs and the weights read, the image
    written, the state read and written, all float32, each once.

    ``width x height`` is the low-resolution input; ``model`` goes to the device ``meta``.
    """
    model = model.to("meta").eval()
    frame = random_frame(model, width, height, "meta")
    state: Any = None
    held, before = 0, -1
    for _ in range(LONGEST):
        if held == before:
            break
        output, state = model(frame, state)
        before, held = held, sum(t.nbytes for t in tree_leaves(state) if isinstance(t, Tensor))
    image = model.present(output, frame)
    inputs = sum(values.nbytes for values in buffers(frame).values())
    return inputs + sum(p.nbytes for p in model.parameters()) + image.nbytes + 2 * held
