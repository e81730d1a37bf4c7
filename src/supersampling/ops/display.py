"""The display transform of the project's own renders, as `render/shaders/display.glsl` computes it."""

import torch
from torch import Tensor


def displayed(radiance: Tensor) -> Tensor:
    """Linear exposed radiance to display-referred sRGB in [0, 1], any shape, elementwise.

    Narkowicz 2015, "ACES Filmic Tone Mapping Curve", then the sRGB curve (IEC 61966-2-1). Negative radiance counts as 0. The
    curve is a quotient of squares, so radiance above 1e6, long since 1, is cut before it overflows.
    """
    x = radiance.clamp(0.0, 1e6)
    x = (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
    # The power's derivative is infinite at 0, where the other branch is taken.
    bright = 1.055 * x.clamp_min(1e-6) ** (1.0 / 2.4) - 0.055
    return torch.where(x < 0.0031308, 12.92 * x, bright)
