"""Slot ``pad``: the substitute for history that is not finite or outside the previous image (Swensen 2021, 4.1.2)."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor, nn

from supersampling.ops.warp import broken_pixels, outside


class Pad(nn.Module, ABC):
    """The padded history, ``forward(history, aligned (B, C, H, W), motion (B, 2, H, W)) -> (B, C, H, W)``.

    ``aligned`` is the jitter-aligned input in the history's channels. Values that are not finite are replaced here as
    well: they would stay in the history, and spread with every reprojection.
    """

    @abstractmethod
    def forward(self, history: Tensor, aligned: Tensor, motion: Tensor) -> Tensor: ...


@final
class JitterAligned(Pad):
    """The jitter-aligned current frame, as the thesis does."""

    def forward(self, history: Tensor, aligned: Tensor, motion: Tensor) -> Tensor:
        return torch.where(outside(motion) | broken_pixels(history), aligned, history)


@final
class Zeros(Pad):
    """Black, as Xiao et al. 2020 do."""

    def forward(self, history: Tensor, aligned: Tensor, motion: Tensor) -> Tensor:
        return history.masked_fill(outside(motion) | broken_pixels(history), 0.0)
