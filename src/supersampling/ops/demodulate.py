"""Separation of radiance into material and lighting, and its inverse (Li et al. 2024, NSRD, section 3.1, eqs 2 to 4).

``radiance = F_beta * lighting + emission``: emission, and the sky's radiance where there is no surface, bypass the
product and are never divided.
"""

import torch
from torch import Tensor

# The smallest F_beta used as a divisor: float16's smallest normal number. Buffers are stored in float16, where smaller
# values have fewer digits than a radiance, and dividing a radiance of 4 by them would overflow float16. Nothing visible
# is lost: lit by radiance 1, a surface this dark stays below a fifth of the first step of 8-bit sRGB (3.0e-4).
MIN_MATERIAL = 2.0**-14


def _at_least_float32(*buffers: Tensor) -> tuple[Tensor, ...]:
    """Convert all to the widest type among them, at least float32 (half of the range of lighting exceeds float16)."""
    dtype = torch.float32
    for buffer in buffers:
        dtype = torch.promote_types(dtype, buffer.dtype)
    return tuple(buffer.to(dtype) for buffer in buffers)


def demodulate(radiance: Tensor, material: Tensor, emission: Tensor) -> Tensor:
    """Return the lighting component ``I = (L - emission) / F_beta`` (equation 4).

    `remodulate` restores the radiance up to rounding wherever ``F_beta >= MIN_MATERIAL``. Below that, a surface counts
    as black: its lighting is 0, with finite (zero) gradients. Radiance below the emission, which only rounding can
    cause, is treated as equal to it, so that lighting is never negative.

    Args:
        radiance: ``L (B, 3, h, w)``, linear, with emission and sky.
        material: ``F_beta (B, 3, h, w)``, non-negative; see `supersampling.ops.brdf.material`.
        emission: ``(B, 3, h, w)``, linear; the sky's radiance where there is no surface.

    Returns:
        ``(B, 3, h, w)``, non-negative; float32 (float64 if an argument is), also for half-precision inputs.
    """
    radiance, material, emission = _at_least_float32(radiance, material, emission)
    black = material < MIN_MATERIAL
    # Replace the divisor before the division: masking only the quotient would leave 0 * inf = NaN in the gradient.
    lighting = (radiance - emission).clamp(min=0.0) / material.masked_fill(black, 1.0)
    return lighting.masked_fill(black, 0.0)


def remodulate(lighting: Tensor, material: Tensor, emission: Tensor) -> Tensor:
    """Return the radiance ``F_beta * lighting + emission`` (equation 2), ``(B, 3, h, w)``, in at least float32.

    Arguments as in `demodulate`, all at one resolution: super-resolved lighting needs the high-resolution ``F_beta``.
    """
    lighting, material, emission = _at_least_float32(lighting, material, emission)
    return material * lighting + emission
