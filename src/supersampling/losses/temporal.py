"""Losses between one frame and the next, which follow the motion."""

from collections.abc import Mapping
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError
from supersampling.losses.base import Loss
from supersampling.losses.pixel import check_beta
from supersampling.ops.motion_mask import motion_mask
from supersampling.ops.resample import upsample_motion
from supersampling.ops.temporal import carry_error, spatiotemporal_error
from supersampling.ops.warp import finite_motion, warp


@final
class SpatioTemporal(Loss):
    """The linearised spatio-temporal loss (Swensen 2021, eqs 54 and 55): ``|x| + |y| + theta (|x - y| - |x| -
    |y|)``.

    ``x`` is the frame's error, ``y`` the previous frame's, warped here. ``theta = 0`` is spatial only, and
    twice an L1 in size; towards 1 only changes of the error count, and at 1 nothing ties the output to the
    target.
    """

    requires = frozenset({"motion"})
    previous = 1

    def __init__(self, theta: float) -> None:
        super().__init__()
        if not 0.0 <= theta <= 1.0:
            raise UserError(f"loss.theta must lie in [0, 1], got {theta}; the thesis tries 0.1, 0.5 and 0.9.")
        self.theta = theta

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        motion = frames["motion"]
        error = outputs - targets
        carried = carry_error(error[:, :-1].flatten(0, 1), motion[:, 1:].flatten(0, 1))
        return spatiotemporal_error(error[:, 1:].flatten(0, 1), carried, self.theta).mean()


@final
class MaskedTemporal(Loss):
    """NSRD's temporal loss (Li et al. 2024, eq 7): smooth L1 between the previous output, warped here, and the output, both
    times the inverse motion mask ``M``, of vectors that are upsampled bilinearly first; the mean is over all pixels, hidden
    ones too.

    The paper leaves open: whether gradients reach the previous output (here they do), and what becomes of pixels that were
    out of the image (here its border is repeated, and their vectors are equal, so that they count).

    Args:
        threshold: low-resolution pixels, above 0; the paper's is 0.1.
        beta: of smooth L1, above 0.
    """

    requires = frozenset({"motion", "motion_dual"})
    previous = 1

    def __init__(self, threshold: float, beta: float) -> None:
        super().__init__()
        if not 0.0 < threshold < float("inf"):
            raise UserError(f"threshold of the motion mask must be above 0, got {threshold}; the paper's is 0.1.")
        self.threshold, self.beta = threshold, check_beta(beta)

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        size = (outputs.shape[-2], outputs.shape[-1])
        outputs = outputs.to(torch.promote_types(outputs.dtype, frames["motion"].dtype))  # half under autocast
        motion, motion_dual = (finite_motion(frames[name][:, 1:].flatten(0, 1)) for name in ("motion", "motion_dual"))
        carried = warp(outputs[:, :-1].flatten(0, 1), upsample_motion(motion, size))
        # Upsampling is linear: of the difference it is the difference of both.
        offset = upsample_motion(motion_dual - motion, size)
        seen = 1.0 - motion_mask(offset, (motion.shape[-2], motion.shape[-1]), self.threshold)
        return F.smooth_l1_loss(seen * carried, seen * outputs[:, 1:].flatten(0, 1), beta=self.beta)
