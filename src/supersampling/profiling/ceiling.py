"""Highest rates of this machine, in a large matrix product and in a large copy."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

SIDE = {"cpu": 1536, "cuda": 8192}  # of the matrices: large enough for the full rate
COPIED = {"cpu": 2**27, "cuda": 2**30}  # bytes: larger than caches


@dataclass(frozen=True)
class Ceiling:
    """Multiply-accumulates per second in a matrix product, and bytes read and written per second in a copy."""

    macs: float
    bytes: float


Run = Callable[[], object]


class Kernels:
    """Operations on a device that are ready to be timed: the same matrix product in several libraries, and a copy.

    A 1x1 convolution is a matrix product. On an AMD processor it runs in oneDNN, which is twice as fast as MKL, the
    library of `torch.mm`. With the rate of `torch.mm` as ceiling, a method could reach more than 100 %.

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
        self._source = torch.rand(COPIED.get(device.type, COPIED["cuda"]) // 4, device=device)
        self._target = torch.empty_like(self._source)
        self.bytes = 2 * self._source.nbytes

    def copy(self) -> None:
        self._target.copy_(self._source)


def _product(a: Tensor, b: Tensor) -> Run:
    multiply = torch.mm if a.dtype.is_floating_point else torch._int_mm
    out = torch.empty_like(a, dtype=a.dtype if a.dtype.is_floating_point else torch.int32)
    return lambda: multiply(a, b, out=out)


def _convolution(a: Tensor, b: Tensor) -> Run:
    """Return the product as a 1x1 convolution: ``a``'s columns are the pixels of one row, its rows their channels."""
    side = len(a)
    image = a.view(1, side, 1, side).contiguous(memory_format=torch.channels_last)
    weights = b.view(side, side, 1, 1).contiguous(memory_format=torch.channels_last)
    return lambda: torch.conv2d(image, weights)


def synchronise(device: torch.device) -> None:
    """Wait until the device has finished all submitted work."""
    if device.type == "cuda":
        torch.cuda.synchronize(device)


@torch.inference_mode()
def measure(device: torch.device, dtype: torch.dtype, times: int) -> Ceiling:
    """Return the ceiling from the fastest of ``times`` runs: it is the possible rate, not the usual one.

    TF32 stays off, as in the methods' float32.
    """
    kernels = Kernels(device, dtype)
    fastest = []
    for run in (*kernels.products, kernels.copy):
        run()
        seconds = []
        for _ in range(times):
            synchronise(device)
            start = time.perf_counter()
            run()
            synchronise(device)
            seconds.append(time.perf_counter() - start)
        fastest.append(min(seconds))
    return Ceiling(kernels.macs / min(fastest[:-1]), kernels.bytes / fastest[-1])
