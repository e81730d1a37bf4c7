"""Preparation of outputs for scoring: finite values within the range and, optionally, in 8 bits."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor

HIGHEST_RADIANCE = float(torch.finfo(torch.float16).max)
"""The largest value of a radiance buffer."""


def bounded(output: Tensor, target: Tensor, highest: float = 1.0) -> Tensor:
    """Return ``output``, of any shape, clamped to ``[0, highest]``, as a display or a float16 buffer does.

    NaN and infinities become the end of the range that is farther from ``target``: no other value would score worse
    there. So a broken pixel costs as much as possible in every metric, and a broken frame is never left out of a mean.
    """
    worst = torch.where(target < 0.5 * highest, highest, 0.0)
    return torch.where(output.isfinite(), output, worst.to(output)).clamp(0.0, highest)


class Prepare(ABC):
    """Base class of ``prepare(output, target) -> output``: the display-referred image ``(B, 3, H, W)`` to score."""

    @abstractmethod
    def __call__(self, output: Tensor, target: Tensor) -> Tensor: ...


@final
class Continuous(Prepare):
    """No quantisation; values are only `bounded`."""

    def __call__(self, output: Tensor, target: Tensor) -> Tensor:
        return bounded(output, target)


@final
class EightBit(Prepare):
    """Rounding to the nearest of 256 steps, as in a PNG or on a display; targets are stored in this form.

    Values within half a step of the target then equal it.
    """

    def __call__(self, output: Tensor, target: Tensor) -> Tensor:
        return (bounded(output, target) * 255.0).round() / 255.0
