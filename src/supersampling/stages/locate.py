"""Slot ``locate``: NSRD's knowledge of the samples' positions in their pixels. An addition of this framework.

The paper (Li et al. 2024) samples at pixel centres. Where data is jittered by ``J`` low-resolution pixels, NSRD works
in two frames of reference:

- Buffers that are rendered at low resolution, and features of them: pixel ``p`` holds the scene at its centre + ``J``.
  Its motion is that of this point, and itself without jitter. In the previous image, whose samples lie at centre +
  ``J'``, the point is therefore at the pixel position ``centre + J + motion - J'``: motion plus the change of jitter
  ``J - J'``.
- The output, also as blocks of channels of low-resolution pixels: it lies at the target pixels' centres, without
  jitter. The previous output moves by the motion only, which however is known at centre + ``J``. The ConvLSTM's state,
  which is not warped at all, lies on the blocks as well; the offset of the samples from a block is ``J``, the same for
  all pixels.
"""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.ops.resample import jitter_aligned_upsample, jitter_as_motion, upsample_motion


class Locate(nn.Module, ABC):
    """The handling of jitter in NSRD's inputs and motion.

    ``channels`` is the number of channels that `append` adds, ``requires`` names the buffers that are read. ``memory``
    is what `remember` returned for the previous frame, ``()`` if this frame stands in for it, without motion.
    """

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        """Return the tensors of this frame that the next frame needs."""

    @abstractmethod
    def append(self, inputs: Tensor, frame: Frame) -> Tensor:
        """Return ``inputs (B, C, h, w)`` followed by channels of their positions, ``(B, C + channels, h, w)``."""

    @abstractmethod
    def between_samples(self, vectors: Tensor, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor:
        """Return ``vectors (B, V, h, w)``, motion first, with motion between the two images' pixels instead of points.

        Such vectors of several frames add up to another one (`supersampling.ops.chain.chain`): the inner jitters
        cancel.
        """

    @abstractmethod
    def at_target(self, motion: Tensor, frame: Frame, scale: int) -> Tensor:
        """Return ``motion (B, 2, h, w)`` at the target pixels' centres, ``(B, 2, s h, s w)``, in units of the image."""


@final
class Unlocated(Locate):
    """No knowledge of positions: samples count as lying at pixel centres, as in the paper."""

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

    The planes are in low-resolution pixels, as in Mercier et al. 2023, eq 2. Warping them with a previous frame's
    inputs leaves them unchanged, so the gated convolution reads that frame's own jitter. The change of jitter is added
    to the two components of motion only: a motion mask, computed from differences of vectors, stays 0 where nothing
    moves.
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
