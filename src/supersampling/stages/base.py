"""Slot ``base``: the image that a network's prediction is added to. No base class of stages.

The slot is an addition of this framework: NSRR and NSRD (Xiao et al. 2020, Li et al. 2024) have no such connection from
the input to the output.
"""

from abc import ABC, abstractmethod
from typing import final

from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.ops.resample import jitter_aligned_upsample


class Base(nn.Module, ABC):
    """The output, ``forward(predicted (B, 3, s h, s w), light (B, 3, h, w), frame) -> (B, 3, s h, s w)``.

    ``light`` is the network's colour input, in the same domain as its output. ``requires`` names the buffers that are
    read.
    """

    requires: frozenset[str]

    @abstractmethod
    def forward(self, predicted: Tensor, light: Tensor, frame: Frame) -> Tensor: ...


@final
class NoBase(Base):
    """The network's prediction is the output."""

    requires = frozenset[str]()

    def forward(self, predicted: Tensor, light: Tensor, frame: Frame) -> Tensor:
        return predicted


@final
class JitterAlignedBase(Base):
    """The prediction is added to the current frame's jitter-aligned bilinear upsampling (Swensen 2021, 4.1.1).

    The network then only predicts the difference from interpolation, and short trainings start near the image instead
    of at black.
    """

    requires = frozenset({"jitter"})

    def forward(self, predicted: Tensor, light: Tensor, frame: Frame) -> Tensor:
        scale = predicted.shape[-1] // light.shape[-1]
        return predicted + jitter_aligned_upsample(light, frame.need("jitter"), scale)
