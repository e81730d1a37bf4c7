"""Slot ``warp_at``: the resolution at which previous frames are kept and warped (Xiao et al. 2020, 3.2.2 and table 9).

Backward warps, bilinear. What comes from outside the previous image is zero, as where no sample was taken; the paper is
silent on it, and Swensen 2021, 4.1.2, says that it pads with zeros.
"""

from abc import ABC, abstractmethod
from typing import final

from torch import Tensor, nn

from supersampling.ops.resample import jitter_as_motion, upsample_motion
from supersampling.ops.warp import outside, warp
from supersampling.stages.upsample import Upsample

State = tuple[Tensor, ...]


class WarpAt(nn.Module, ABC):
    """``enter`` brings a frame to the resolution that is warped at, ``leave`` to the target resolution.

    In between, ``keep`` makes a state of the window of frames, and ``forward`` on the next frame a window of the state.
    ``jitter`` is the frame's ``(B, 2)`` (x, y) in low-resolution pixels, ``scale`` a whole number.
    """

    @abstractmethod
    def enter(self, features: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        """This frame's features ``(B, C, h, w)`` as the window holds them, ``(B, C, ., .)``."""

    @abstractmethod
    def keep(self, window: Tensor, jitter: Tensor) -> State:
        """The state: the window, any number of channels, and what its next warp needs."""

    @abstractmethod
    def forward(self, state: State, motion: Tensor, jitter: Tensor) -> Tensor:
        """The previous frame's window seen from this frame, by ``motion (B, 2, h, w)`` in image units."""

    @abstractmethod
    def leave(self, window: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        """The window at the target resolution ``(B, C, H, W)``."""


@final
class TargetResolution(WarpAt):
    """Upsample, then warp by the bilinearly upsampled motion: the paper's way. Zero motion is the identity to the bit."""

    def enter(self, features: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        return upsample(features, jitter, scale)

    def keep(self, window: Tensor, jitter: Tensor) -> State:
        return (window,)

    def forward(self, state: State, motion: Tensor, jitter: Tensor) -> Tensor:
        (window,) = state
        height, width = window.shape[-2:]
        return _warp(window, upsample_motion(motion, (height, width)))

    def leave(self, window: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        return window


@final
class LowResolution(WarpAt):
    """Warp, then upsample (the first two rows of table 9).

    A low-resolution image does not say where in its pixels the samples lie, so the change of jitter is added to the motion, and
    the state holds the jitter. Without jitter, as in the paper, nothing is added, and zero motion is the identity to the bit.
    """

    def enter(self, features: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        return features

    def keep(self, window: Tensor, jitter: Tensor) -> State:
        return window, jitter

    def forward(self, state: State, motion: Tensor, jitter: Tensor) -> Tensor:
        window, previous_jitter = state
        height, width = window.shape[-2:]
        return _warp(window, motion + jitter_as_motion(jitter - previous_jitter, height, width))

    def leave(self, window: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        return upsample(window, jitter, scale)


def _warp(image: Tensor, motion: Tensor) -> Tensor:
    return warp(image, motion).masked_fill(outside(motion), 0.0)
