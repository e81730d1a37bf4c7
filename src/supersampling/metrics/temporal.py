"""The temporal metrics of Swensen 2021, table 10: eq 55 at ``theta`` 0 and 1, one value per frame.

``output, target, previous_output, previous_target`` are ``(B, 3, H, W)``, ``motion`` is this frame's ``(B, 2, h, w)``;
both functions return ``(B,)``. They warp the previous frame by the motion vectors: bilinear, with its border repeated.
"""

import math
from typing import final

from torch import Tensor

from supersampling.metrics.base import FrameMetric, Moment
from supersampling.ops.temporal import carry_error, spatiotemporal_error


def spatial_loss(
    output: Tensor, target: Tensor, previous_output: Tensor, previous_target: Tensor, motion: Tensor
) -> Tensor:
    """Return ``L_0``, the mean of ``|x| + |y|``: the L1 errors of this and of the previous frame together."""
    return _mean_error(output - target, previous_output - previous_target, motion, theta=0.0)


def temporal_loss(
    output: Tensor, target: Tensor, previous_output: Tensor, previous_target: Tensor, motion: Tensor
) -> Tensor:
    """Return ``L_1``, the mean of ``|x - y|``: the change of the error along the motion; blind to a constant error."""
    return _mean_error(output - target, previous_output - previous_target, motion, theta=1.0)


def _mean_error(error: Tensor, previous: Tensor, motion: Tensor, theta: float) -> Tensor:
    return spatiotemporal_error(error, carry_error(previous, motion), theta).mean(dim=(1, 2, 3))


@final
class Temporal(FrameMetric):
    """``spatial`` and ``temporal``, the two losses of Swensen 2021, table 10; no value for a clip's first frame."""

    better = {"spatial": "lower", "temporal": "lower"}
    requires = frozenset({"target", "motion"})

    def measure(self, moment: Moment) -> list[float]:
        if moment.previous is None:
            return [math.nan, math.nan]
        assert moment.motion is not None
        images = (moment.output, moment.target, *moment.previous)
        return [loss(*images, moment.motion).item() for loss in (spatial_loss, temporal_loss)]
