"""The memory of a step, from shapes only, so that a size that cannot fit is reported and not tried."""

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
DOUBLE = 2.0  # the reference is in float64
COMPARISON = 1.5  # results are kept for the comparison


class Peak(TorchDispatchMode):
    """A dispatch mode that records the largest number of bytes allocated at once by tensors created inside it."""

    def __init__(self) -> None:
        super().__init__()
        self.now = self.peak = 0
        self._users: Counter[int] = Counter()

    def __torch_dispatch__(
        self, func: Any, types: Sequence[Any], args: Sequence[Any] = (), kwargs: Mapping[str, Any] | None = None
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
                weakref.finalize(tensor, self._release, key, size)
        return out

    def _release(self, key: int, size: int) -> None:
        self._users[key] -= 1
        if not self._users[key]:
            self.now -= size


@torch.no_grad()
def estimate_gigabytes(model: Upsampler, width: int, height: int) -> float:
    """Return about how much memory it takes to compare a step of a ``width x height`` input with float64.

    NaN if the model cannot run on shapes only.
    """
    shapes = copy.deepcopy(model).to("meta").eval()
    frame = random_frame(shapes, width, height, "meta")
    try:
        with Peak() as peak:
            _, state = shapes(frame, None)
            shapes(frame, state)
    except (RuntimeError, NotImplementedError):
        return float("nan")
    return peak.peak * DOUBLE * COMPARISON / GIGA


def explain_too_large(model: Upsampler, size: tuple[int, int], device: str) -> str:
    """Return the reason that a size is not tried on this machine; empty if it fits."""
    required, free = estimate_gigabytes(model, *size), available(torch.device(device))
    if free is not None and required > free / GIGA:
        return f"needs about {required:.0f} GB beside float64, and {free / GIGA:.0f} GB are free"
    return ""
