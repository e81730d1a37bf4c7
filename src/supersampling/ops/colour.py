"""Colour spaces. Channels are in dimension -3."""

import torch
from torch import Tensor


def rgb_to_ycocg(rgb: Tensor) -> Tensor:
    """Convert RGB ``(..., 3, H, W)`` to YCoCg (Swensen 2021, eq 32).

    For RGB in [0, 1], Y is in [0, 1], Co and Cg in [-0.5, 0.5].
    """
    r, g, b = rgb.unbind(-3)
    return torch.stack(((r + 2.0 * g + b) * 0.25, (r - b) * 0.5, (2.0 * g - r - b) * 0.25), dim=-3)


def ycocg_to_rgb(ycocg: Tensor) -> Tensor:
    """Convert YCoCg ``(..., 3, H, W)`` to RGB (Swensen 2021, eq 33), the inverse of `rgb_to_ycocg`."""
    y, co, cg = ycocg.unbind(-3)
    return torch.stack((y + co - cg, y + cg, y - co - cg), dim=-3)
