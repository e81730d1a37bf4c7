"""Bilinear upsampling of the current frame only."""

from typing import final

import torch.nn.functional as F
from torch import Tensor

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale


@final
class Bilinear(Upsampler[None]):
    """Bilinear interpolation that ignores jitter ("normal bilinear upsampling", Swensen 2021, 4.1.1 and figure 4)."""

    requires = frozenset({"color"})

    def __init__(self, scale: int) -> None:
        super().__init__()
        self.scale = check_scale(scale)

    def forward(self, frame: Frame, state: None) -> tuple[Tensor, None]:
        output = F.interpolate(frame.need("color"), scale_factor=self.scale, mode="bilinear", align_corners=False)
        # Interpolation of values in [0, 1] may leave the range by a rounding step.
        return output.clamp(0.0, 1.0), None
