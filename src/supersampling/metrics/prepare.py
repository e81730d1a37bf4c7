"""What an output becomes before it is scored: finite, inside of its range and, if so chosen, in 8 bits."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor

HIGHEST_RADIANCE = float(torch.finfo(torch.float16).max)
"""What radiance buffers can hold."""


def bounded(output: Tensor, target: Tensor, highest: float = 1.0) -> Tensor:
    """``output`` in ``[0, highest]``, any shape: values outside are cut to it, as a display or a float16 buffer does.

    NaN and infinities become the end of the range that is farther from ``target``: no other value would score worse there. So a
    broken pixel costs the most that one can, in every metric, and a broken frame is never left out of a mean.
    """
    worst = torch.where(target < 0.5 * highest, highest, 0.0)
    return torch.where(output.isfinite(), output, worst.to(output)).clamp(0.0, highest)


class Prepare(ABC):
    """``prepare(output, target) -> output``: the display-referred image ``(B, 3, H, W)`` in [0, 1] that is scored."""

    @abstractmethod
    def __call__(self, output: Tensor, target: Tensor) -> Tensor: ...


@final
class Continuous(Prepare):
    """As it is, but for what `bounded` does."""

    def __call__(self, output: Tensor, target: Tensor) -> Tensor:
        return bounded(output, target)


@final
class EightBit(Prepare):
    """The nearest of 256 steps, as a PNG or a display holds it; targets are stored so.

    What is within half a step of the target then equals it.
    """

    def __call__(self, output: Tensor, target: Tensor) -> Tensor:
        return (bounded(output, target) * 255.0).round() / 255.0
