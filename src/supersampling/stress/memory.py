"""How much memory a step takes, from shapes alone, so that what cannot fit is told and not tried."""

import copy
import weakref
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from supersampling.models.base import Upsampler
from supersampling.models.count import random_frame
from supersampling.profiling.memory import available

GIGA = 1e9
DOUBLE, HELD = 2.0, 1.5  # the reference is in float64, and what is kept for the comparison
OPERATIONS = 2e12  # multiply-accumulates of a step above which a row is too long for any budget: minutes


class Peak(TorchDispatchMode):
    """The largest number of bytes that tensors made inside of it held at once."""

    def __init__(self) -> None:
        super().__init__()
        self.now = self.peak = 0
        self._users: Counter[int] = Counter()

    def __torch_dispatch__(
        self,
        func: Any,
        types: Sequence[Any],
        args: Sequence[Any] = (),
        kwargs: Mapping[str, Any] | None = None,
    ) -> Any:
        out = func(*args, **(kwargs or {}))
        for tensor in tree_leaves(out):
            if isinstance(tensor, Tensor):
                storage = tensor.untyped_storage()
                key, size = storage._cdata, storage.nbytes()
                if not self._users[key]:
                    self.now += size
                    self.peak = max(self.peak, self.now)
                self._users[key] += 1
                weakref.finalize(tensor, self._gone, key, size)
        return out

    def _gone(self, key: int, size: int) -> None:
        self._users[key] -= 1
        if not self._users[key]:
            self.now -= size


@torch.no_grad()
def gigabytes(model: Upsampler, width: int, height: int) -> float:
    """About what comparing a step of a ``width x height`` input with float64 takes; NaN where shapes alone do not say."""
    shapes = copy.deepcopy(model).to("meta").eval()
    frame = random_frame(shapes, width, height, "meta")
    try:
        with Peak() as peak:
            _, state = shapes(frame, None)
            shapes(frame, state)
    except (RuntimeError, NotImplementedError):
        return float("nan")
    return peak.peak * DOUBLE * HELD / GIGA


def too_large(model: Upsampler, size: tuple[int, int], device: str) -> str:
    """Why a size is not tried on this machine; empty if it fits."""
    needed, free = gigabytes(model, *size), available(torch.device(device))
    if free is not None and needed > free / GIGA:
        return f"needs about {needed:.0f} GB beside float64, and {free / GIGA:.0f} GB are free"
    return ""
