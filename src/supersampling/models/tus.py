"""TUS: temporal upsampling by hand-crafted rules (Swensen 2021, 2.4.3 to 2.4.6 and 5.3.1)."""

from typing import final

import torch
from torch import Tensor

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale, gaussian_upsample, jitter_aligned_upsample, upsample_motion
from supersampling.stages.dilate import Dilate
from supersampling.stages.gate import Gate, setting_at
from supersampling.stages.pad import Pad
from supersampling.stages.rectify import Rectify
from supersampling.stages.reproject import Reproject


@final
class TUS(Upsampler[Tensor]):
    """Rectified history blended with Gaussian-reconstructed samples.

    The state is the history ``(B, 3, H, W)``. The thesis uses history clamping, bicubic reprojection, no dilation,
    ``alpha`` 0.5 for 2x2 and 1.0 for 4x4, and DLCTUS's first frame and padding; it does not state ``sigma``.

    Args:
        scale: ``s``.
        sigma: standard deviation of the reconstruction kernel in target pixels, positive (eq 41).
        alpha: blending factor in [0, 1] (eq 39).
        reproject, rectify, dilate, pad: stages.
    """

    extremes = (
        Gate("gate/alpha 0", "TUS: no sample is blended in.", setting_at(0.0, "alpha")),
        Gate("gate/alpha 1", "TUS: a sample at a target pixel replaces it.", setting_at(1.0, "alpha")),
        Gate("gate/sigma 1e-3", "TUS: a kernel whose every weight underflows.", setting_at(1e-3, "sigma")),
        Gate("gate/sigma 1e3", "TUS: a kernel as wide as the image.", setting_at(1e3, "sigma")),
    )

    def __init__(
        self, scale: int, sigma: float, alpha: float, reproject: Reproject, rectify: Rectify, dilate: Dilate, pad: Pad
    ) -> None:
        super().__init__()
        if not sigma > 0.0:
            raise UserError(f"Invalid model.sigma={sigma}: use a positive number of target pixels; the default is 0.8.")
        if not 0.0 <= alpha <= 1.0:
            raise UserError(
                f"Invalid model.alpha={alpha}: use a value in [0, 1]; the thesis has 0.5 at 2x2, 1.0 at 4x4."
            )
        self.scale = check_scale(scale)
        self.sigma, self.alpha = sigma, alpha
        self.reproject, self.rectify, self.dilate, self.pad = reproject, rectify, dilate, pad
        self.requires = frozenset({"color", "jitter", "motion"}) | dilate.requires

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
        samples, beta = gaussian_upsample(color, jitter, self.scale, self.sigma)
        output = torch.lerp(history, samples, self.alpha * beta).clamp(0.0, 1.0)  # eq 39
        return output, output
