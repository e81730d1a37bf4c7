"""Slot ``upsample``: the placement of samples at the target resolution (Xiao et al. 2020, 3.2.2 and table 9)."""

from abc import ABC, abstractmethod
from typing import final

from torch import Tensor, nn

from supersampling.ops.resample import jitter_aligned_upsample, zero_upsample


class Upsample(nn.Module, ABC):
    """The upsampled image, ``forward(image (B, C, h, w), jitter (B, 2), scale) -> (B, C, scale * h, scale * w)``.

    The paper samples at pixel centres. Jittered samples are placed where they were taken, as in every method here.
    """

    @abstractmethod
    def forward(self, image: Tensor, jitter: Tensor, scale: int) -> Tensor: ...


@final
class ZeroUpsampling(Upsample):
    """Each sample at the target pixel that contains it, zeros around it.

    At an even scale a pixel's centre lies between four target pixels, and the paper does not say which one takes the
    sample: here the one to the right of and below the centre.
    """

    def forward(self, image: Tensor, jitter: Tensor, scale: int) -> Tensor:
        return zero_upsample(image, jitter, scale)


@final
class BilinearUpsampling(Upsample):
    """Bilinear interpolation between the samples, with borders repeated."""

    def forward(self, image: Tensor, jitter: Tensor, scale: int) -> Tensor:
        return jitter_aligned_upsample(image, jitter, scale)
