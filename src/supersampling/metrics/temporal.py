"""The temporal metrics of Swensen 2021, table 10: eq 55 at ``theta`` 0 and 1, one value a frame.

``output, target, previous_output, previous_target`` are ``(B, 3, H, W)``, ``motion`` is this frame's ``(B, 2,
h, w)``; both return ``(B,)``. The previous frame is warped here by the motion vectors, bilinear, its border
repeated.
"""

from torch import Tensor

from supersampling.ops.temporal import carry_error, spatiotemporal_error


def spatial_loss(
    output: Tensor, target: Tensor, previous_output: Tensor, previous_target: Tensor, motion: Tensor
) -> Tensor:
    """``L_0``: mean of ``|x| + |y|``, the L1 errors of this and of the previous frame together."""
    return _mean_error(output - target, previous_output - previous_target, motion, theta=0.0)


def temporal_loss(
    output: Tensor, target: Tensor, previous_output: Tensor, previous_target: Tensor, motion: Tensor
) -> Tensor:
    """``L_1``: mean of ``|x - y|``, how much the error changes along the motion; blind to a constant
    error."""
    return _mean_error(output - target, previous_output - previous_target, motion, theta=1.0)


def _mean_error(error: Tensor, previous: Tensor, motion: Tensor, theta: float) -> Tensor:
    return spatiotemporal_error(error, carry_error(previous, motion), theta).mean(dim=(1, 2, 3))
