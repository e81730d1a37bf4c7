"""Errors by region: disoccluded pixels, for which a method has no history, and static pixels.

The regions depend on motion only, so that every method is scored on the same pixels. ``size`` is the target's ``(H,
W)``.
"""

import math
from typing import final

import torch
from torch import Tensor

from supersampling.metrics.base import FrameMetric, Moment
from supersampling.metrics.image import PSNR_CAP
from supersampling.ops.motion_mask import motion_mask
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside

STILL = 0.01
"""Target pixels per frame, on both axes: less motion counts as none. The rounding of rendered motion is near 1e-4."""


def static(motion: Tensor, size: tuple[int, int]) -> Tensor:
    """Return ``(B, 1, H, W)`` bool: motion ``(B, 2, h, w)``, upsampled bilinearly, is below `STILL` on both axes."""
    height, width = size
    x, y = upsample_motion(motion, size).split(1, dim=1)
    return (x.abs() * width < STILL) & (y.abs() * height < STILL)


def disoccluded(motion: Tensor, motion_dual: Tensor, size: tuple[int, int]) -> Tensor:
    """Return ``(B, 1, H, W)`` bool: the point was hidden in the previous frame or outside of it.

    Hidden points are those of NSRD's motion mask with its published threshold. Both motions are ``(B, 2, h, w)``.
    """
    offset = upsample_motion(motion_dual - motion, size)
    low = (motion.shape[-2], motion.shape[-1])
    return (motion_mask(offset, low) > 0.0) | outside(upsample_motion(motion, size))


def region_psnr(output: Tensor, target: Tensor, region: Tensor) -> float:
    """Return the PSNR in dB of a region ``(1, 1, H, W)`` bool over RGB; at most `PSNR_CAP`, NaN for an empty region."""
    count = region.sum()
    if count == 0:
        return math.nan
    square = (output - target).square().mean(dim=1, keepdim=True)
    error = torch.where(region, square, 0.0).sum() / count
    return -10.0 * error.clamp_min(10.0 ** (-PSNR_CAP / 10.0)).log10().item()


@final
class Regions(FrameMetric):
    """PSNR of disoccluded and of static pixels, each with the PSNR of all other pixels and the region's share of the
    frame.

    A clip's first frame has no value. To weight frames by the size of the region instead of equally: the squared error
    of a region is ``10 ** (-psnr / 10)`` and its weight is the fraction.
    """

    better = {
        "psnr_disoccluded": "higher",
        "psnr_elsewhere": "higher",
        "fraction_disoccluded": "neither",
        "psnr_static": "higher",
        "psnr_moving": "higher",
        "fraction_static": "neither",
    }
    requires = frozenset({"target", "motion", "motion_dual"})

    def measure(self, moment: Moment) -> list[float]:
        if moment.previous is None:
            return [math.nan] * len(self.names)
        assert moment.motion is not None
        assert moment.motion_dual is not None
        size = (moment.target.shape[-2], moment.target.shape[-1])
        values: list[float] = []
        for region in (disoccluded(moment.motion, moment.motion_dual, size), static(moment.motion, size)):
            values += [region_psnr(moment.output, moment.target, mask) for mask in (region, ~region)]
            values.append(region.float().mean().item())
        return values
