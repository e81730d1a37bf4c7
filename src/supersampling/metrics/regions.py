"""Errors by region: where a method has no history, and where nothing moves.

The regions follow from motion alone, so that every method is judged on the same pixels. ``size`` is the target's ``(H, W)``.
"""

from typing import final

import torch
from torch import Tensor

from supersampling.metrics.image import PSNR_CAP
from supersampling.metrics.suite import Metric, Moment
from supersampling.ops.motion_mask import motion_mask
from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import outside

STILL = 0.01
"""Target pixels a frame, on both axes: less motion than this counts as none. Rounding of rendered motion is near 1e-4."""


def static(motion: Tensor, size: tuple[int, int]) -> Tensor:
    """``(B, 1, H, W)`` bool: the motion ``(B, 2, h, w)``, upsampled bilinearly, is less than `STILL` on both axes."""
    height, width = size
    x, y = upsample_motion(motion, size).split(1, dim=1)
    return (x.abs() * width < STILL) & (y.abs() * height < STILL)


def disoccluded(motion: Tensor, motion_dual: Tensor, size: tuple[int, int]) -> Tensor:
    """``(B, 1, H, W)`` bool: the point was hidden in the previous frame (NSRD's motion mask with its published threshold) or
    outside of it. Both motions are ``(B, 2, h, w)``."""
    offset = upsample_motion(motion_dual - motion, size)
    low = (motion.shape[-2], motion.shape[-1])
    return (motion_mask(offset, low) > 0.0) | outside(upsample_motion(motion, size))


def region_psnr(output: Tensor, target: Tensor, region: Tensor) -> float:
    """PSNR in dB over the RGB values of a region ``(1, 1, H, W)`` bool, at most `PSNR_CAP`; NaN for an empty region."""
    count = region.sum()
    if count == 0:
        return float("nan")
    square = (output - target).square().mean(dim=1, keepdim=True)
    error = torch.where(region, square, 0.0).sum() / count
    return -10.0 * error.clamp_min(10.0 ** (-PSNR_CAP / 10.0)).log10().item()


@final
class Regions(Metric):
    """PSNR of a frame's regions, and the fraction of pixels that two of them cover (the others are the rest).

    A clip's first frame has no value. To pool frames by their pixels instead of alike: the squared error of a region is
    ``10 ** (-psnr / 10)`` and its weight the fraction.
    """

    names = (
        "psnr_disoccluded", "psnr_elsewhere", "fraction_disoccluded", "psnr_static", "psnr_moving", "fraction_static",
    )  # fmt: skip
    requires = frozenset({"target", "motion", "motion_dual"})

    def __call__(self, moment: Moment) -> dict[str, float]:
        if moment.previous is None:
            return dict.fromkeys(self.names, float("nan"))
        assert moment.motion is not None
        assert moment.motion_dual is not None
        size = (moment.target.shape[-2], moment.target.shape[-1])
        values: list[float] = []
        for region in (
            disoccluded(moment.motion, moment.motion_dual, size),
            static(moment.motion, size),
        ):
            values += [region_psnr(moment.output, moment.target, where) for where in (region, ~region)]
            values.append(region.float().mean().item())
        return dict(zip(self.names, values))
