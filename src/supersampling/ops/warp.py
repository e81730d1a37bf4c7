"""Backward warping by motion vectors: (x, y) in units of the whole image, ``previous_uv = uv + motion``."""

from collections.abc import Callable

import torch
from torch import Tensor

from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.resample import pixel_centres

# Tolerance in halves of an image: 16 rounding steps of float32, a 250th of a pixel at a width of 7680.
EDGE = 2.0**-20
# In images: interpolation with this motion still leads outside, and half precision can store it.
FAR = 1e4
# float16's maximum: no colour or radiance beyond it is stored, and a history beyond it is rejected.
LARGEST = 65504.0


def sampling_grid(motion: Tensor) -> Tensor:
    """Convert motion ``(B, 2, H, W)`` to ``grid_sample`` positions ``(B, H, W, 2)`` in the previous frame."""
    _, _, height, width = motion.shape
    x = pixel_centres(width, motion) + 2.0 * motion[:, 0]
    y = pixel_centres(height, motion)[:, None] + 2.0 * motion[:, 1]
    return torch.stack((x, y), dim=-1)


def outside(motion: Tensor) -> Tensor:
    """Return ``(B, 1, H, W)`` bool: the previous position lies outside the image (Swensen 2021, 4.1.2), or is NaN.

    Positions on the image's border are inside, and so are those less than `EDGE` beyond it: motion by half a target
    pixel leads there, where the result would otherwise depend on rounding.
    """
    return ~(sampling_grid(motion).abs().amax(dim=-1) <= 1.0 + EDGE).unsqueeze(1)


def finite_motion(motion: Tensor) -> Tensor:
    """Replace NaN and infinite motion by motion far outside: PyTorch's gradient of a warp by NaN ends the process."""
    return torch.nan_to_num(motion, FAR, FAR, -FAR)


def broken_pixels(history: Tensor) -> Tensor:
    """Return ``(B, 1, H, W)`` bool: a channel of the history is NaN or infinite, or their sum is beyond `LARGEST`."""
    return ~(history.sum(dim=1, keepdim=True).abs() <= LARGEST)


def warp(image: Tensor, motion: Tensor, sample: Callable[[Tensor, Tensor], Tensor] = sample_bilinear) -> Tensor:
    """Warp the previous ``image (B, C, H, W)`` to the current frame; borders are repeated.

    Pixels without motion are copied exactly: float32 grid positions are accurate only to ``max(H, W) * 2**-24`` pixels,
    and a history that is resampled in every frame would accumulate that error.

    Args:
        image: ``(B, C, H, W)``.
        motion: ``(B, 2, H, W)``, target resolution.
        sample: interpolation ``(image, grid) -> (B, C, H, W)``.
    """
    still = (motion == 0.0).all(dim=1, keepdim=True)
    return torch.where(still, image, sample(image, sampling_grid(motion)))
