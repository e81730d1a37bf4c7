"""Slot ``motion_mask``: a mask of the warped pixels that were hidden (Li et al. 2024, NSRD, 3.2 and figure 8)."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.ops.motion_mask import THRESHOLD, motion_mask


class MotionMask(nn.Module, ABC):
    """The warped inputs with a mask, ``forward(warped (B, C, h, w), vectors (B, V, h, w)) -> (B, C + channels, h, w)``.

    ``vectors`` lead from the current frame to the one that was warped: motion first, then what else the stage needs.
    Over several frames they add up along the motion (`supersampling.ops.chain.chain`). ``requires`` names the buffers
    that are read.
    """

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def vectors(self, frame: Frame) -> Tensor:
        """Return the vectors ``(B, V, h, w)`` to the previous frame, in units of the image; motion comes first."""

    @abstractmethod
    def forward(self, warped: Tensor, vectors: Tensor) -> Tensor: ...


@final
class DualMotionMask(MotionMask):
    """A channel that is 1 where dual and traditional motion differ by at least ``threshold`` low-resolution pixels.

    The paper does not say what the mask of the frame before last is: here it is computed from the differences, summed
    along the motion.
    """

    channels = 1
    requires = frozenset({"motion", "motion_dual"})

    def __init__(self, threshold: float = THRESHOLD) -> None:
        super().__init__()
        if not threshold > 0.0:
            raise UserError(
                f"Invalid motion_mask.threshold={threshold}: use a positive number of low-resolution pixels; "
                "the paper has 0.1."
            )
        self.threshold = threshold

    def vectors(self, frame: Frame) -> Tensor:
        motion, dual = frame.need("motion", "motion_dual")
        return torch.cat((motion, dual - motion), dim=1)

    def forward(self, warped: Tensor, vectors: Tensor) -> Tensor:
        _, _, h, w = vectors.shape
        return torch.cat((warped, motion_mask(vectors[:, 2:], (h, w), self.threshold)), dim=1)


@final
class NoMotionMask(MotionMask):
    """No mask: the gated convolution reads the warped buffers only (figure 8).

    The paper does not say how that variant was wired; this is the smallest change that removes the mask.
    """

    channels = 0
    requires = frozenset({"motion"})

    def vectors(self, frame: Frame) -> Tensor:
        return frame.need("motion")

    def forward(self, warped: Tensor, vectors: Tensor) -> Tensor:
        return warped
