"""Slot ``colour_space``: the space in which a network reads and predicts colour (Xiao et al. 2020, 3.2.5)."""

from typing import final

import torch
from torch import Tensor

from supersampling.stages.rectify import RGB, ColourSpace

__all__ = ["RGB", "ColourSpace", "YCbCr"]


@final
class YCbCr(ColourSpace):
    """Luma and two colour differences of BT.601 in full range, as in JPEG: RGB in [0, 1] gives channels in [0, 1].

    The paper does not say which YCbCr; with the colour differences centred at 0.5 its losses see images of range 1.
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
