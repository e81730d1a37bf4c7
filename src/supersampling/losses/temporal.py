"""Losses between consecutive frames along the motion."""

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
    """Linearised spatio-temporal loss (Swensen 2021, eqs 54 and 55): ``|x| + |y| + theta (|x - y| - |x| - |y|)``.

    ``x`` is the frame's error, ``y`` the previous frame's error, warped to this frame. ``theta = 0`` is spatial only,
    and twice as large as L1; as ``theta`` approaches 1, only changes of the error count, and at 1 nothing ties the
    output to the target.

    Each of the counted frames has a previous one: 5 pairs for 5 counted frames, where the thesis has 5 targets, so 4
    pairs. Its program warps zeros in from outside the image; here the border is repeated, as in the metrics.
    """

    requires = frozenset({"motion"})
    previous = 1

    def __init__(self, theta: float) -> None:
        super().__init__()
        if isinstance(theta, bool) or not isinstance(theta, (int, float)) or not 0.0 <= theta <= 1.0:
            raise UserError(
                f"Invalid loss.theta={theta}: use a number between 0 and 1 (the thesis tries 0.1, 0.5 and 0.9)."
            )
        self.theta = theta
        self.label = f"theta={theta}"

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        motion = frames["motion"]
        error = outputs - targets
        warped = carry_error(error[:, :-1].flatten(0, 1), motion[:, 1:].flatten(0, 1))
        return spatiotemporal_error(error[:, 1:].flatten(0, 1), warped, self.theta).mean()


@final
class MaskedTemporal(Loss):
    """NSRD's temporal loss (Li et al. 2024, eq 7).

    Smooth L1 between the warped previous output and the output, both multiplied by the inverse motion mask ``M`` of
    vectors that are first upsampled bilinearly. The mean is over all pixels, including hidden ones.

    The paper does not specify whether gradients reach the previous output (here they do), nor how to treat pixels that
    were outside the image (here the border is repeated, and their two vectors are equal, so that they count).

    Args:
        threshold: low-resolution pixels, positive; 0.1 in the paper.
        beta: parameter of smooth L1, positive.
    """

    requires = frozenset({"motion", "motion_dual"})
    previous = 1

    def __init__(self, threshold: float, beta: float) -> None:
        super().__init__()
        if not 0.0 < threshold < float("inf"):
            raise UserError(
                f"Invalid threshold={threshold} of the motion mask: use a positive number (0.1 in the paper)."
            )
        self.threshold, self.beta = threshold, check_beta(beta)

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        size = (outputs.shape[-2], outputs.shape[-1])
        # Outputs are in half precision under autocast.
        outputs = outputs.to(torch.promote_types(outputs.dtype, frames["motion"].dtype))
        motion, motion_dual = (finite_motion(frames[name][:, 1:].flatten(0, 1)) for name in ("motion", "motion_dual"))
        warped = warp(outputs[:, :-1].flatten(0, 1), upsample_motion(motion, size))
        # Upsampling is linear: upsampling the difference equals the difference of the upsampled vectors.
        offset = upsample_motion(motion_dual - motion, size)
        visible = 1.0 - motion_mask(offset, (motion.shape[-2], motion.shape[-1]), self.threshold)
        return F.smooth_l1_loss(visible * warped, visible * outputs[:, 1:].flatten(0, 1), beta=self.beta)
