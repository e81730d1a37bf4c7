"""Slot ``warp_at``: the resolution of stored and warped previous frames (Xiao et al. 2020, 3.2.2 and table 9).

Backward warps, bilinear. Pixels from outside the previous image are zero, as are pixels without a sample; the paper
does not say so, but Swensen 2021, 4.1.2, says that it pads with zeros.
"""

from abc import ABC, abstractmethod
from typing import final

from torch import Tensor, nn

from supersampling.ops.resample import jitter_as_motion, upsample_motion
from supersampling.ops.warp import outside, warp
from supersampling.stages.upsample import Upsample

State = tuple[Tensor, ...]


class WarpAt(nn.Module, ABC):
    """The window of previous frames: ``enter`` brings a frame to the window's resolution, ``leave`` to the target's.

    In between, ``keep`` turns the window of frames into a state, and on the next frame ``forward`` turns the state into
    a window. ``jitter`` is the frame's, ``(B, 2)`` (x, y) in low-resolution pixels; ``scale`` is a whole number.
    """

    @abstractmethod
    def enter(self, features: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        """Return this frame's features ``(B, C, h, w)`` at the window's resolution, ``(B, C, ., .)``."""

    @abstractmethod
    def keep(self, window: Tensor, jitter: Tensor) -> State:
        """Return the state: the window, with any number of channels, and what its next warp needs."""

    @abstractmethod
    def forward(self, state: State, motion: Tensor, jitter: Tensor) -> Tensor:
        """Return the previous frame's window warped to this frame by ``motion (B, 2, h, w)``, in units of the image."""

    @abstractmethod
    def leave(self, window: Tensor, jitter: Tensor, scale: int, upsample: Upsample) -> Tensor:
        """Return the window at the target resolution, ``(B, C, H, W)``."""


@final
class TargetResolution(WarpAt):
    """Upsampling, then a warp by the bilinearly upsampled motion, as in the paper; no motion is the exact identity."""

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
    """A warp, then upsampling (the first two rows of table 9).

    A low-resolution image does not contain the positions of the samples in its pixels, so the change of jitter is added
    to the motion, and the state holds the jitter. Without jitter, as in the paper, nothing is added, and zero motion is
    the exact identity.
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
