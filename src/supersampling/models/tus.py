"""TUS: temporal upsampling by hand-crafted rules (Swensen 2021, 2.4.3 to 2.4.6 and 5.3.1)."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import (
    check_scale,
    gaussian_upsample,
    jitter_aligned_upsample,
    upsample_motion,
    zero_upsample,
)
from supersampling.stages.dilate import Dilate
from supersampling.stages.gate import Gate, setting_at
from supersampling.stages.pad import Pad
from supersampling.stages.rectify import Rectify
from supersampling.stages.reproject import Reproject


class TemporalUpsampler(Upsampler[Tensor], ABC):
    """Rectified history blended with the samples of the frame; a subclass says how far a sample reaches.

    The state is the history ``(B, 3, H, W)``. The thesis uses history clamping, bicubic reprojection, no dilation, and
    DLCTUS's first frame and padding (5.3.1).

    Args:
        scale: ``s``.
        alpha: blending factor in [0, 1] (eq 39).
        reproject, rectify, dilate, pad: stages.
    """

    extremes = (
        Gate("gate/alpha 0", "TUS: no sample is blended in.", setting_at(0.0, "alpha")),
        Gate("gate/alpha 1", "TUS: a sample at a target pixel replaces it.", setting_at(1.0, "alpha")),
    )

    def __init__(
        self, scale: int, alpha: float, reproject: Reproject, rectify: Rectify, dilate: Dilate, pad: Pad
    ) -> None:
        super().__init__()
        if not 0.0 <= alpha <= 1.0:
            raise UserError(
                f"Invalid model.alpha={alpha}: use a value in [0, 1]; the thesis has 0.5 at 2x2, 1.0 at 4x4."
            )
        self.scale, self.alpha = check_scale(scale), alpha
        self.reproject, self.rectify, self.dilate, self.pad = reproject, rectify, dilate, pad
        self.requires = frozenset({"color", "jitter", "motion"}) | dilate.requires

    @abstractmethod
    def samples(self, color: Tensor, jitter: Tensor) -> tuple[Tensor, Tensor]:
        """Return the frame's samples at target resolution ``(B, 3, H, W)`` (eq 38) and ``beta (B, 1, H, W)``."""

    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        color, jitter, motion = frame.need("color", "jitter", "motion")
        aligned = jitter_aligned_upsample(color, jitter, self.scale)
        if state is None:
            history = aligned
        else:
            height, width = aligned.shape[-2:]
            motion = upsample_motion(self.dilate(motion, frame.depth), (height, width))
            history = self.pad(self.reproject(state, motion), aligned, motion)
        history = self.rectify(history, color)
        samples, beta = self.samples(color, jitter)
        output = torch.lerp(history, samples, self.alpha * beta).clamp(0.0, 1.0)  # eq 39
        return output, output


@final
class TUS(TemporalUpsampler):
    """TUS with a Gaussian kernel (eqs 41 and 42), as Unreal Engine 4 has it: stronger than the thesis's own.

    Args:
        sigma: standard deviation of the kernel in target pixels, positive (eq 41); the thesis states none.
        scale, alpha, reproject, rectify, dilate, pad: as in `TemporalUpsampler`.
    """

    extremes = (
        Gate("gate/sigma 1e-3", "TUS: a kernel whose every weight underflows.", setting_at(1e-3, "sigma")),
        Gate("gate/sigma 1e3", "TUS: a kernel as wide as the image.", setting_at(1e3, "sigma")),
    )

    def __init__(
        self, scale: int, sigma: float, alpha: float, reproject: Reproject, rectify: Rectify, dilate: Dilate, pad: Pad
    ) -> None:
        super().__init__(scale, alpha, reproject, rectify, dilate, pad)
        if not sigma > 0.0:
            raise UserError(f"Invalid model.sigma={sigma}: use a positive number of target pixels; the default is 0.8.")
        self.sigma = sigma

    def samples(self, color: Tensor, jitter: Tensor) -> tuple[Tensor, Tensor]:
        return gaussian_upsample(color, jitter, self.scale, self.sigma)


@final
class TUSThesis(TemporalUpsampler):
    """TUS as the thesis measured it in table 2, with nothing to tune: Yang's box of one pixel (2.4.6).

    A sample is the colour of the target pixel that it lies in, where ``beta = 1``; elsewhere ``beta = 0``. The text's
    "then beta = 0, otherwise beta = 0" is a misprint, and the thesis's program does this.

    Args:
        alpha: blending factor in [0, 1], None for the thesis's (5.3.1): 0.5 at 2x2, where a pixel gets several samples,
            and 1.0 at 4x4, where it gets one at its centre. Other scales, which the thesis does not have, take that of
            the next smaller one.
        scale, reproject, rectify, dilate, pad: as in `TemporalUpsampler`.
    """

    def __init__(
        self, scale: int, alpha: float | None, reproject: Reproject, rectify: Rectify, dilate: Dilate, pad: Pad
    ) -> None:
        published = 0.5 if scale < 4 else 1.0
        super().__init__(scale, published if alpha is None else alpha, reproject, rectify, dilate, pad)

    def samples(self, color: Tensor, jitter: Tensor) -> tuple[Tensor, Tensor]:
        spread = zero_upsample(torch.cat((color, torch.ones_like(color[:, :1])), dim=1), jitter, self.scale)
        return spread[:, :3], spread[:, 3:]
