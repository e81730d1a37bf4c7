"""Least work of a frame, computed from shapes only."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from torch import Tensor
from torch.utils._pytree import tree_leaves

from supersampling.deploy.check import buffers
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.count import LONGEST, count_modules, random_frame


@dataclass(frozen=True)
class Workload:
    """Parameters of a method; multiply-accumulates and moved bytes per frame, NaN if shapes do not determine them."""

    parameters: int
    macs: float
    bytes: float


def workload(config: Mapping[str, Any], width: int, height: int) -> Workload:
    """Return the workload of a configured method at a low-resolution size; NaN if the method does not run there."""
    parameters = 0
    try:
        model: Upsampler = instantiate(dict(config))
        parameters = sum(p.numel() for p in model.parameters())
        macs = float(count_modules(model, width, height)[-1].macs)
        return Workload(parameters, macs, float(bytes_moved(model, width, height)))
    except (UserError, InstantiationException, RuntimeError, ValueError):
        return Workload(parameters, math.nan, math.nan)


@torch.no_grad()
def bytes_moved(model: Upsampler, width: int, height: int) -> int:
    """Return the least number of bytes that a frame reads and writes once the state has its full size.

    Inputs and weights are read, the image is written, the state is read and written; all are float32, each once.
    ``width x height`` is the low-resolution input; ``model`` is moved to the device ``meta``.
    """
    model = model.to("meta").eval()
    frame = random_frame(model, width, height, "meta")
    state: Any = None
    state_bytes, before = 0, -1
    for _ in range(LONGEST):
        if state_bytes == before:
            break
        output, state = model(frame, state)
        before, state_bytes = state_bytes, sum(t.nbytes for t in tree_leaves(state) if isinstance(t, Tensor))
    image = model.present(output, frame)
    inputs = sum(values.nbytes for values in buffers(frame).values())
    return inputs + sum(p.nbytes for p in model.parameters()) + image.nbytes + 2 * state_bytes
