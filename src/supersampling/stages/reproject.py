"""Slot ``reproject``: the interpolation of the history at the previous position (Swensen 2021, 4.1.2 and 5.5.1)."""

from abc import ABC, abstractmethod
from functools import partial
from typing import final

from torch import Tensor, nn

from supersampling.ops.interpolate import TORCH_CUBIC, check_cubic, sample_bicubic5, sample_bicubic9, sample_bilinear
from supersampling.ops.warp import warp


class Reproject(nn.Module, ABC):
    """The warped history, ``forward(history (B, C, H, W), motion (B, 2, H, W)) -> (B, C, H, W)``.

    Zero motion is the identity, bit for bit.
    """

    @abstractmethod
    def forward(self, history: Tensor, motion: Tensor) -> Tensor: ...


@final
class Bilinear(Reproject):
    """One bilinear fetch."""

    def forward(self, history: Tensor, motion: Tensor) -> Tensor:
        return warp(history, motion, sample_bilinear)


@final
class Bicubic5(Reproject):
    """Five fetches: the cubic kernel without its corners, renormalised, as in Unreal Engine 4 with ``a = -0.5``.

    The thesis set ``a = -0.75`` and observed errors that grow over time in rare places (6.1.1).
    """

    def __init__(self, a: float = TORCH_CUBIC) -> None:
        super().__init__()
        self.a = check_cubic(a)

    def forward(self, history: Tensor, motion: Tensor) -> Tensor:
        return warp(history, motion, partial(sample_bicubic5, a=self.a))


@final
class Bicubic9(Reproject):
    """The full cubic kernel; PyTorch and the thesis have ``a = -0.75``, Catmull-Rom is ``a = -0.5``."""

    def __init__(self, a: float = TORCH_CUBIC) -> None:
        super().__init__()
        self.a = check_cubic(a)

    def forward(self, history: Tensor, motion: Tensor) -> Tensor:
        return warp(history, motion, partial(sample_bicubic9, a=self.a))
