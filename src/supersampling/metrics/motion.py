"""The distance of motion vectors' ends to pixel centres: how much a fetch of the history has to interpolate."""

import math
from typing import final

from torch import Tensor

from supersampling.metrics.base import FrameMetric, Moment
from supersampling.ops.resample import upsample_motion


def pixel_distance(motion: Tensor, size: tuple[int, int]) -> Tensor:
    """Return the mean distance ``(B,)`` from where motion points to the closest pixel centre, in target pixels.

    0 if every fetch is of whole pixels, at most ``sqrt(0.5)``, 0.38 for motion without a preferred distance (Swensen
    2021, figure 7 and 6.1.1).

    Args:
        motion: ``(B, 2, h, w)``, in units of the image.
        size: ``(H, W)`` of the history, to which motion is upsampled as for reprojection.
    """
    height, width = size
    moved = upsample_motion(motion, size) * motion.new_tensor((width, height))[:, None, None]
    return (moved - moved.round()).norm(dim=1).mean(dim=(1, 2))


@final
class PixelDistance(FrameMetric):
    """``pixel_distance``, a property of the clip, not of the method; NaN for a clip's first frame."""

    better = {"pixel_distance": "neither"}
    requires = frozenset({"target", "motion"})

    def measure(self, moment: Moment) -> list[float]:
        if moment.previous is None:
            return [math.nan]
        assert moment.motion is not None
        return [pixel_distance(moment.motion, (moment.target.shape[-2], moment.target.shape[-1])).item()]
