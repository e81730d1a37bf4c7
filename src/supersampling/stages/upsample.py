"""Slot ``upsample``: how low-resolution samples reach the target resolution (Xiao et al. 2020, 3.2.2 and table 9)."""

from abc import ABC, abstractmethod
from typing import final

from torch import Tensor, nn

from supersampling.ops.resample import jitter_aligned_upsample, zero_upsample


class Upsample(nn.Module, ABC):
    """``forward(image (B, C, h, w), jitter (B, 2), scale) -> (B, C, scale * h, scale * w)``.

    The paper samples at pixel centres. Jittered samples go where they were taken, as in every method here.
    """

    @abstractmethod
    def forward(self, image: Tensor, jitter: Tensor, scale: int) -> Tensor: ...


@final
class ZeroUpsampling(Upsample):
    """Every sample at the target pixel that holds it, zeros around it.

    At an even scale a pixel's centre lies between four target pixels; which one takes it the paper leaves open: the one
    right of and below the centre.
    """

    def forward(self, image: Tensor, jitter: Tensor, scale: int) -> Tensor:
        return zero_upsample(image, jitter, scale)


@final
class BilinearUpsampling(Upsample):
    """Bilinear interpolation between the samples, borders repeated."""

    def forward(self, image: Tensor, jitter: Tensor, scale: int) -> Tensor:
        return jitter_aligned_upsample(image, jitter, scale)
