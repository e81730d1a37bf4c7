"""JAU: jitter-aligned upsampling of the current frame only (Swensen 2021, 4.1.1)."""

from abc import ABC
from typing import Literal, final

from torch import Tensor

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale, jitter_aligned_upsample


class JitterAligned(Upsampler[None], ABC):
    """Upsampling that keeps every sample at the position where it was taken."""

    requires = frozenset({"color", "jitter"})
    mode: Literal["bilinear", "bicubic"]

    def __init__(self, scale: int) -> None:
        super().__init__()
        self.scale = check_scale(scale)

    def forward(self, frame: Frame, state: None) -> tuple[Tensor, None]:
        color, jitter = frame.need("color", "jitter")
        # Interpolation of values in [0, 1] may leave the range: bilinear by a rounding step, bicubic by its overshoot.
        return jitter_aligned_upsample(color, jitter, self.scale, mode=self.mode).clamp(0.0, 1.0), None


@final
class JAU(JitterAligned):
    """Bilinear upsampling that keeps every sample at the position where it was taken."""

    mode = "bilinear"


@final
class BicubicJAU(JitterAligned):
    """JAU with bicubic interpolation (``a = -0.75``), which the thesis's figure 4 compares with the bilinear one."""

    mode = "bicubic"
