"""Slot ``locate``: what NSRD knows of where in their pixels the samples lie. A switch of this framework.

The paper (Li et al. 2024) samples at pixel centres. Where data is jittered by ``J`` low-resolution pixels, NSRD works in two
frames of reference:

- Everything that is rendered at low resolution, and features of it: pixel ``p`` holds the scene at its centre + ``J``. Motion
  is that of this point, itself without jitter. In the previous image, whose samples lie at centre + ``J'``, the point is
  therefore found at the pixel position ``centre + J + motion - J'``: motion plus the change of jitter ``J - J'``.
- Everything of the output's, as its low-resolution pixels' blocks of channels are: at the target pixels' centres, without
  jitter. The previous output moves by motion alone, which however is known at centre + ``J``. The ConvLSTM's state, which is
  not warped at all, lies on the blocks as well; how the samples lie to a block is ``J``, the same for all pixels.
"""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.ops.resample import jitter_aligned_upsample, jitter_as_motion, upsample_motion


class Locate(nn.Module, ABC):
    """``channels`` is how many `append` adds, ``requires`` names what is read of a frame.

    ``memory`` is what `remember` kept of the previous frame, ``()`` where that frame counts as this one standing still.
    """

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def remember(self, frame: Frame) -> tuple[Tensor, ...]: ...

    @abstractmethod
    def append(self, inputs: Tensor, frame: Frame) -> Tensor:
        """The frame's ``inputs (B, C, h, w)`` and what tells the network where they lie, ``(B, C + channels, h, w)``."""

    @abstractmethod
    def between_samples(self, vectors: Tensor, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor:
        """``vectors (B, V, h, w)``, motion first, with motion between the two images' pixels instead of between points.

        Such vectors of several frames add up to such a vector (`supersampling.ops.chain.chain`): inner jitters cancel.
        """

    @abstractmethod
    def at_target(self, motion: Tensor, frame: Frame, scale: int) -> Tensor:
        """``motion (B, 2, h, w)`` at the target pixels' centres, ``(B, 2, s h, s w)``; both in units of the image."""


@final
class Unlocated(Locate):
    """Nothing is known: samples count as lying at pixel centres, the paper's case."""

    channels = 0
    requires = frozenset[str]()

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        return ()

    def append(self, inputs: Tensor, frame: Frame) -> Tensor:
        return inputs

    def between_samples(self, vectors: Tensor, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor:
        return vectors

    def at_target(self, motion: Tensor, frame: Frame, scale: int) -> Tensor:
        _, _, h, w = motion.shape
        return upsample_motion(motion, (h * scale, w * scale))


@final
class LocatedByJitter(Locate):
    """The jitter as two constant planes, and in every warp.

    The planes are in low-resolution pixels, as in Mercier et al. 2023, eq 2. Warped with a previous frame's inputs, which leaves
    them what they are, they tell the gated convolution that frame's own jitter. Only the two components of motion take up the
    change of jitter: a motion mask, made of differences of vectors, stays 0 where nothing moves.
    """

    channels = 2
    requires = frozenset({"jitter"})

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        return (frame.need("jitter"),)

    def append(self, inputs: Tensor, frame: Frame) -> Tensor:
        planes = frame.need("jitter")[..., None, None].expand(-1, -1, *inputs.shape[-2:])
        return torch.cat((inputs, planes), dim=1)

    def between_samples(self, vectors: Tensor, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor:
        if not memory:
            return vectors
        _, count, h, w = vectors.shape
        shift = jitter_as_motion(frame.need("jitter") - memory[0], h, w)
        return vectors + F.pad(shift, (0, 0, 0, 0, 0, count - 2))

    def at_target(self, motion: Tensor, frame: Frame, scale: int) -> Tensor:
        return jitter_aligned_upsample(motion, frame.need("jitter"), scale)
