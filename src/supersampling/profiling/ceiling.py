"""What this machine reaches at best: a large matrix product, and a large copy."""

import time
from dataclasses import dataclass

import torch

SIDE = {"cpu": 1536, "cuda": 8192}  # of the matrices: large enough for the full rate
COPIED = {"cpu": 2**27, "cuda": 2**30}  # bytes, more than caches hold


@dataclass(frozen=True)
class Ceiling:
    """Multiply-accumulates a second in a matrix product, and bytes read and written a second in a copy."""

    macs: float
    bytes: float


class Kernels:
    """The two operations on a device, ready to be timed.

    Raises:
        RuntimeError: the device has no matrix product of this type.
    """

    def __init__(self, device: torch.device, dtype: torch.dtype) -> None:
        side = SIDE.get(device.type, SIDE["cuda"])
        self.macs = side**3
        self._multiply = torch.mm if dtype.is_floating_point else torch._int_mm
        self._a, self._b = (torch.randn(side, side, device=device).to(dtype) for _ in range(2))
        self._product = torch.empty(
            side, side, device=device, dtype=dtype if dtype.is_floating_point else torch.int32
        )
        self._from = torch.rand(COPIED.get(device.type, COPIED["cuda"]) // 4, device=device)
        self._to = torch.empty_like(self._from)
        self.bytes = 2 * self._from.nbytes

    def product(self) -> None:
        self._multiply(self._a, self._b, out=self._product)

    def copy(self) -> None:
        self._to.copy_(self._from)


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
    for run in (kernels.product, kernels.copy):
        run()
        taken = []
        for _ in range(times):
            synchronise(device)
            began = time.perf_counter()
            run()
            synchronise(device)
            taken.append(time.perf_counter() - began)
        best.append(min(taken))
    return Ceiling(kernels.macs / best[0], kernels.bytes / best[1])
