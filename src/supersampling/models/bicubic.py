"""Bicubic upsampling of the current frame only."""

from typing import final

import torch.nn.functional as F
from torch import Tensor

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale


@final
class Bicubic(Upsampler[None]):
    """PyTorch's bicubic interpolation (``a = -0.75``), which ignores jitter."""

    requires = frozenset({"color"})

    def __init__(self, scale: int) -> None:
        super().__init__()
        self.scale = check_scale(scale)

    def forward(self, frame: Frame, state: None) -> tuple[Tensor, None]:
        output = F.interpolate(frame.need("color"), scale_factor=self.scale, mode="bicubic", align_corners=False)
        return output.clamp(0.0, 1.0), None
