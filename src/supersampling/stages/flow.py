"""Slot ``flow``: how the motion from the current to the previous frame is known (Mercier et al. 2023, section 4.1, "Jitter
compensation", and section 6.2)."""

from abc import ABC, abstractmethod
from typing import final

import numpy as np
import torch
from skimage.registration import optical_flow_tvl1
from torch import Tensor, nn

from supersampling.frames import Frame

LUMA = (0.2126, 0.7152, 0.0722)  # Rec. 709
SMALLEST = 4  # pixels a side; below, TV-L1 has no neighbourhood to work on


def compensate_jitter(motion: Tensor, jitter: Tensor, previous: Tensor) -> Tensor:
    """``MV_t + J_{t-1} - J_t`` (eq 1): motion between two jittered images without what the jitter adds to it.

    Args:
        motion: ``(B, 2, h, w)``, backward, units of the image: where a pixel's sample lies in the previous image.
        jitter, previous: ``(B, 2)`` of this frame and the previous one, low-resolution pixels.
    """
    h, w = motion.shape[-2:]
    return motion + ((previous - jitter) / jitter.new_tensor((w, h)))[..., None, None]


class Flow(nn.Module, ABC):
    """``forward(frame, memory) -> (B, 2, h, w)``: unjittered backward motion as `Frame.motion`, or None for "stay in place".

    ``memory`` is what `remember` kept of the previous frame. ``requires`` names what is read.
    """

    requires: frozenset[str]

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        return ()

    @abstractmethod
    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None: ...


@final
class MotionVectors(Flow):
    """The renderer's motion vectors, which are free of jitter (`frames`): equation 1 has been applied where they were made."""

    requires = frozenset({"motion"})

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        return frame.motion


@final
class JitteredMotionVectors(Flow):
    """Motion vectors that still hold the jitter's part, as some captures have them; equation 1 removes it here."""

    requires = frozenset({"motion", "jitter"})

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        assert frame.jitter is not None
        return (frame.jitter,)

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        assert frame.motion is not None
        assert frame.jitter is not None
        return compensate_jitter(frame.motion, frame.jitter, *memory)


@final
class TVL1(Flow):
    """Optical flow estimated from the two frames' luma by scikit-image, for the row "(-) MVs, (+) RAFT" of table 3.

    The paper has RAFT; TV-L1 (Zach et al. 2007) needs no trained weights. The images are jittered, so equation 1 follows. It
    runs on the processor, item by item, gives no gradient and does not export. Images below 4 pixels a side count as still.
    """

    requires = frozenset({"color", "jitter"})

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        assert frame.color is not None
        assert frame.jitter is not None
        return frame.color, frame.jitter

    @torch.no_grad()
    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        assert frame.color is not None
        assert frame.jitter is not None
        before, previous_jitter = memory
        b, _, h, w = frame.color.shape
        if min(h, w) < SMALLEST:
            return frame.color.new_zeros(b, 2, h, w)
        pairs = zip(_luma(frame.color), _luma(before))
        # (row, column) in pixels: reference(p) = moving(p + flow)
        flows = np.stack([optical_flow_tvl1(now, then)[::-1] for now, then in pairs])
        motion = torch.from_numpy(flows).to(frame.color) / frame.color.new_tensor((w, h)).view(2, 1, 1)
        return compensate_jitter(motion, frame.jitter, previous_jitter)


def _luma(color: Tensor) -> np.ndarray:
    weights = color.new_tensor(LUMA).view(3, 1, 1)
    luma: np.ndarray = (color * weights).sum(dim=1).float().cpu().numpy()
    return luma


@final
class NoFlow(Flow):
    """The history stays in place, no motion is read: the row "(-) warping" of table 3."""

    requires = frozenset[str]()

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        return None
