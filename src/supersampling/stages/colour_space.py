"""Slot ``colour_space``: the space in which a network reads and predicts colour (Xiao et al. 2020, 3.2.5).

The options of the slot ``rectify`` bound the history in such a space (Swensen 2021, 2.4.4).
"""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor

from supersampling.ops.colour import rgb_to_ycocg, ycocg_to_rgb


class ColourSpace(ABC):
    """An affine map of RGB and its inverse, on tensors ``(..., 3, H, W)`` of any range."""

    @abstractmethod
    def of_rgb(self, rgb: Tensor) -> Tensor: ...

    @abstractmethod
    def to_rgb(self, color: Tensor) -> Tensor: ...


@final
class RGB(ColourSpace):
    """The identity."""

    def of_rgb(self, rgb: Tensor) -> Tensor:
        return rgb

    def to_rgb(self, color: Tensor) -> Tensor:
        return color


@final
class YCoCg(ColourSpace):
    """Luma and two chroma axes, in which a bounding box often fits the colours more tightly (Karis 2014)."""

    def of_rgb(self, rgb: Tensor) -> Tensor:
        return rgb_to_ycocg(rgb)

    def to_rgb(self, color: Tensor) -> Tensor:
        return ycocg_to_rgb(color)


@final
class YCbCr(ColourSpace):
    """Luma and two colour differences of BT.601 in full range, as in JPEG: RGB in [0, 1] gives channels in [0, 1].

    The paper does not say which YCbCr it uses; with the colour differences centred at 0.5 its losses see images of
    range 1. Unbounded light gives non-negative luma and differences on both sides of 0.5: nothing is clipped, and
    `to_rgb` removes the offset again.
    """

    def of_rgb(self, rgb: Tensor) -> Tensor:
        r, g, b = rgb.unbind(-3)
        y = 0.299 * r + 0.587 * g + 0.114 * b
        return torch.stack((y, (b - y) / 1.772 + 0.5, (r - y) / 1.402 + 0.5), dim=-3)

    def to_rgb(self, color: Tensor) -> Tensor:
        y, cb, cr = color.unbind(-3)
        r = y + 1.402 * (cr - 0.5)
        b = y + 1.772 * (cb - 0.5)
        return torch.stack((r, (y - 0.299 * r - 0.114 * b) / 0.587, b), dim=-3)
