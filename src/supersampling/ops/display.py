"""Display transform of the built-in renderer, as in `render/shaders/display.glsl`."""

import torch
from torch import Tensor


def linear_to_srgb(linear: Tensor) -> Tensor:
    """Apply the sRGB curve (IEC 61966-2-1) to values in [0, 1], elementwise, any shape."""
    # The derivative of the power is infinite at 0, where the linear branch is used.
    bright = 1.055 * linear.clamp_min(1e-6) ** (1.0 / 2.4) - 0.055
    return torch.where(linear < 0.0031308, 12.92 * linear, bright)


def radiance_to_display(radiance: Tensor) -> Tensor:
    """Convert linear exposed radiance to display-referred sRGB in [0, 1], elementwise, any shape.

    Narkowicz 2015, "ACES Filmic Tone Mapping Curve", then the sRGB curve. Negative radiance counts as
    zero. Radiance above 1e6, where the result has long been 1, is clamped: the curve is a quotient of squares, which
    overflow.
    """
    x = radiance.clamp(0.0, 1e6)
    x = (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
    return linear_to_srgb(x)
