"""Slot ``rectify``: the correction of wrong history towards the current frame's colours (Swensen 2021, 2.4.4).

The bounds are those of the 3x3 low-resolution neighbourhood of each target pixel; pixels outside the image do not
count.
"""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.stages.colour_space import ColourSpace


class Rectify(nn.Module, ABC):
    """The rectified history, ``forward(history (B, 3, H, W), color (B, 3, h, w)) -> (B, 3, H, W)``, all RGB."""

    @abstractmethod
    def forward(self, history: Tensor, color: Tensor) -> Tensor: ...


@final
class NoRectification(Rectify):
    """The history unchanged."""

    def forward(self, history: Tensor, color: Tensor) -> Tensor:
        return history


@final
class Clamp(Rectify):
    """Each channel of the history, in ``space``, clamped to the bounding box (the thesis's TUS)."""

    def __init__(self, space: ColourSpace) -> None:
        super().__init__()
        self.space = space

    def forward(self, history: Tensor, color: Tensor) -> Tensor:
        low, high = (_to_target(bound, history) for bound in _box(self.space.of_rgb(color)))
        clamped = torch.clamp(self.space.of_rgb(history), low, high)
        return self.space.to_rgb(clamped)


@final
class Clip(Rectify):
    """The history moved on a straight line towards the neighbourhood's mean until it enters the bounding box."""

    def __init__(self, space: ColourSpace) -> None:
        super().__init__()
        self.space = space

    def forward(self, history: Tensor, color: Tensor) -> Tensor:
        inside = self.space.of_rgb(color)
        mean = F.avg_pool2d(inside, kernel_size=3, stride=1, padding=1, count_include_pad=False)
        low, high = _box(inside)
        low, high, mean = (_to_target(x, history) for x in (low, high, mean))
        away = self.space.of_rgb(history) - mean
        reach = torch.where(away > 0.0, high - mean, low - mean)
        # A channel equal to the mean sets no limit (0 / 0); the mean may lie outside the box by one rounding step.
        step = torch.where(away == 0.0, 1.0, reach / torch.where(away == 0.0, 1.0, away))
        step = step.amin(dim=1, keepdim=True).clamp(0.0, 1.0)
        return self.space.to_rgb(mean + step * away)


def _box(color: Tensor) -> tuple[Tensor, Tensor]:
    """Return the minimum and maximum of each channel in the 3x3 neighbourhood, ``(B, 3, h, w)`` each."""
    high = F.max_pool2d(color, kernel_size=3, stride=1, padding=1)
    low = -F.max_pool2d(-color, kernel_size=3, stride=1, padding=1)
    return low, high


def _to_target(bound: Tensor, history: Tensor) -> Tensor:
    return F.interpolate(bound, size=history.shape[-2:], mode="nearest-exact")
