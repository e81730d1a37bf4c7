"""What this machine reaches at best: a large matrix product, and a large copy."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

SIDE = {"cpu": 1536, "cuda": 8192}  # of the matrices: large enough for the full rate
COPIED = {"cpu": 2**27, "cuda": 2**30}  # bytes, more than caches hold


@dataclass(frozen=True)
class Ceiling:
    """Multiply-accumulates a second in a matrix product, and bytes read and written a second in a copy."""

    macs: float
    bytes: float


Run = Callable[[], object]


class Kernels:
    """The operations on a device, ready to be timed: a matrix product by each of PyTorch's libraries for one, and a copy.

    A 1x1 convolution is a matrix product. On an AMD processor oneDNN, which computes it, is twice as fast as MKL, which has
    `torch.mm`: measured against that alone, a method could reach more than the ceiling.

    Raises:
        RuntimeError: the device has no matrix product of this type.
    """

    def __init__(self, device: torch.device, dtype: torch.dtype) -> None:
        side = SIDE.get(device.type, SIDE["cuda"])
        self.macs = side**3
        a, b = (torch.randn(side, side, device=device).to(dtype) for _ in range(2))
        self.products = [_product(a, b)]
        if dtype.is_floating_point:
            self.products.append(_convolution(a, b))
        self._from = torch.rand(COPIED.get(device.type, COPIED["cuda"]) // 4, device=device)
        self._to = torch.empty_like(self._from)
        self.bytes = 2 * self._from.nbytes

    def copy(self) -> None:
        self._to.copy_(self._from)


def _product(a: Tensor, b: Tensor) -> Run:
    multiply = torch.mm if a.dtype.is_floating_point else torch._int_mm
    out = torch.empty_like(a, dtype=a.dtype if a.dtype.is_floating_point else torch.int32)
    return lambda: multiply(a, b, out=out)


def _convolution(a: Tensor, b: Tensor) -> Run:
    """``a``'s columns are the pixels of one row, its rows their channels."""
    side = len(a)
    image = a.view(1, side, 1, side).contiguous(memory_format=torch.channels_last)
    weights = b.view(side, side, 1, 1).contiguous(memory_format=torch.channels_last)
    return lambda: torch.conv2d(image, weights)


def synchronise(device: torch.device) -> None:
    """Wait until the device has done what it was given."""
    if device.type == "cuda":
        torch.cuda.synchronize(device)


@torch.inference_mode()
def measure(device: torch.device, dtype: torch.dtype, times: int) -> Ceiling:
    """The best of so many runs of each: a ceiling is what is possible, not what is usual.

    TF32 stays off, as in the methods' own float32.
    """
    kernels = Kernels(device, dtype)
    best = []
    for run in (*kernels.products, kernels.copy):
        run()
        taken = []
        for _ in range(times):
            synchronise(device)
            began = time.perf_counter()
            run()
            synchronise(device)
            taken.append(time.perf_counter() - began)
        best.append(min(taken))
    return Ceiling(kernels.macs / min(best[:-1]), kernels.bytes / best[-1])
