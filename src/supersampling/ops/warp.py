"""Backward warping by motion vectors. Motion is (x, y) in units of the whole image: ``previous_uv = uv +
motion``."""

from collections.abc import Callable

import torch
from torch import Tensor

from supersampling.ops.interpolate import sample_bilinear
from supersampling.ops.resample import pixel_centres

EDGE = 2.0**-20  # of half an image: 16 rounding steps of float32, a 250th of a pixel at 7680
FAR = 1e4  # images; what it is interpolated with lies outside, too, and half precision holds it
LARGEST = 65504.0  # float16's: no colour and no light is stored beyond it, and no history that has more is believed


def sampling_grid(motion: Tensor) -> Tensor:
    """``(B, H, W, 2)`` normalised ``grid_sample`` positions in the previous frame, from motion ``(B, 2, H,
    W)``."""
    _, _, height, width = motion.shape
    x = pixel_centres(width, motion) + 2.0 * motion[:, 0]
    y = pixel_centres(height, motion)[:, None] + 2.0 * motion[:, 1]
    return torch.stack((x, y), dim=-1)


def outside(motion: Tensor) -> Tensor:
    """``(B, 1, H, W)`` bool: the previous position lies outside the image (Swensen 2021, 4.1.2), or is NaN.

    Positions on the image's border are inside, and so are those less than `EDGE` beyond it: motion by half a target pixel leads
    there, where rounding would decide.
    """
    return ~(sampling_grid(motion).abs().amax(dim=-1) <= 1.0 + EDGE).unsqueeze(1)


def finite_motion(motion: Tensor) -> Tensor:
    """Motion that is NaN or infinite leads far out of the image: PyTorch's gradient of a warp by NaN ends the process."""
    return torch.nan_to_num(motion, FAR, FAR, -FAR)


def broken(history: Tensor) -> Tensor:
    """``(B, 1, H, W)`` bool: a channel of the history is NaN or infinite, or their sum is beyond `LARGEST`."""
    return ~(history.sum(dim=1, keepdim=True).abs() <= LARGEST)


def warp(image: Tensor, motion: Tensor, sample: Callable[[Tensor, Tensor], Tensor] = sample_bilinear) -> Tensor:
    """The previous ``image (B, C, H, W)`` seen from the current frame; borders are repeated.

    Pixels without motion are copied to the bit: float32 grid positions are good to ``max(H, W) * 2**-24``
    pixels only, and a history that is resampled every frame would add that up.

    Args:
        image: ``(B, C, H, W)``.
        motion: ``(B, 2, H, W)``, target resolution.
        sample: interpolation ``(image, grid) -> (B, C, H, W)``.
    """
    still = (motion == 0.0).all(dim=1, keepdim=True)
    return torch.where(still, image, sample(image, sampling_grid(motion)))
