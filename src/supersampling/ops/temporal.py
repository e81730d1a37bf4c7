"""Spatio-temporal error (Swensen 2021, 4.3.3), shared by the loss and by the metrics of the thesis's table 10."""

from torch import Tensor

from supersampling.ops.resample import upsample_motion
from supersampling.ops.warp import finite_motion, warp


def spatiotemporal_error(current: Tensor, previous: Tensor, theta: float) -> Tensor:
    """Return ``l(x, y) = |x| + |y| + theta (|x - y| - |x| - |y|)`` elementwise (eq 54).

    ``x`` is the current frame's error, ``y`` the previous frame's. ``theta = 0`` is the spatial error ``|x| + |y|``,
    ``theta = 1`` the temporal error ``|x - y|``.
    """
    return (1.0 - theta) * (current.abs() + previous.abs()) + theta * (current - previous).abs()


def carry_error(error: Tensor, motion: Tensor) -> Tensor:
    """Return ``f_prev``: the previous frame's error ``(B, C, H, W)`` warped bilinearly by motion ``(B, 2, h, w)``.

    Warping is linear, so this is ``f_prev(output) - f_prev(target)``. As in the thesis, it is an approximation where
    the pixel was hidden or outside the image (the border is repeated there).
    """
    height, width = error.shape[-2:]
    return warp(error, upsample_motion(finite_motion(motion), (height, width)))
