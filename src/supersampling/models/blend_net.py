"""BlendNet: a small network chooses for each pixel how much of the warped history is kept."""

from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale, jitter_aligned_upsample, upsample_motion
from supersampling.ops.warp import broken_pixels, outside, warp


@final
class BlendNet(Upsampler[Tensor]):
    """Two convolutions over the upsampled frame and the warped history give the history's share.

    The state is the previous output ``(B, 3, H, W)``.

    Args:
        scale: ``s``.
        width: channels between the convolutions.
    """

    requires = frozenset({"color", "jitter", "motion"})

    def __init__(self, scale: int, width: int) -> None:
        super().__init__()
        if width < 1:
            raise UserError(f"Invalid model.width={width}: use at least 1; the default is 8.")
        self.scale = check_scale(scale)
        self.share = nn.Sequential(
            nn.Conv2d(6, width, 3, padding=1), nn.ReLU(), nn.Conv2d(width, 1, 3, padding=1), nn.Sigmoid()
        )

    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        color, jitter, motion = frame.need("color", "jitter", "motion")
        aligned = jitter_aligned_upsample(color, jitter, self.scale)
        if state is None:
            history = aligned
        else:
            height, width = aligned.shape[-2:]
            motion = upsample_motion(motion, (height, width))
            history = warp(state, motion)
            history = torch.where(outside(motion) | broken_pixels(history), aligned, history)
        share = self.share(torch.cat((aligned, history), dim=1))
        output = (aligned + share * (history - aligned)).clamp(0.0, 1.0)
        return output, output
