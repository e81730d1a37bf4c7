"""The rendering itself: every sample repeated over the target pixels that it covers."""

from typing import final

from torch import Tensor

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale, repeat_upsample


@final
class Nearest(Upsampler[None]):
    """The baseline that every useful method must beat: no filter, no history, no jitter."""

    requires = frozenset({"color"})

    def __init__(self, scale: int) -> None:
        super().__init__()
        self.scale = check_scale(scale)

    def forward(self, frame: Frame, state: None) -> tuple[Tensor, None]:
        return repeat_upsample(frame.need("color"), self.scale), None
