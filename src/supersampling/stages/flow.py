"""Slot ``flow``: the source of the motion from the current to the previous frame.

Mercier et al. 2023, section 4.1, "Jitter compensation", and section 6.2.
"""

from abc import ABC, abstractmethod
from typing import final

import numpy as np
import torch
import torch.nn.functional as F
from skimage.registration import optical_flow_tvl1
from torch import Tensor, nn
from torchvision.models import get_model

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.ops.resample import jitter_as_motion
from supersampling.pretrained import load_pretrained

LUMA = (0.2126, 0.7152, 0.0722)  # Rec. 709
SMALLEST = 4  # pixels per side; below, TV-L1 has no neighbourhood to work on
RAFTS = ("raft_large", "raft_small")
RAFT_BLOCK, RAFT_SMALLEST = 8, 128  # pixels: the divisor of a side, and its least length


def compensate_jitter(motion: Tensor, jitter: Tensor, previous: Tensor) -> Tensor:
    """Return ``MV_t + J_{t-1} - J_t`` (eq 1): motion between two jittered images without the part due to the jitter.

    Args:
        motion: ``(B, 2, h, w)``, backward, in units of the image: the offset to a pixel's sample in the previous image.
        jitter, previous: ``(B, 2)`` of this frame and of the previous one, in low-resolution pixels.
    """
    h, w = motion.shape[-2:]
    return motion + jitter_as_motion(previous - jitter, h, w)


class Flow(nn.Module, ABC):
    """Unjittered backward motion as in `Frame.motion`, ``forward(frame, memory) -> (B, 2, h, w)``; None for no motion.

    ``memory`` is what `remember` returned for the previous frame. ``requires`` names the buffers that are read.
    """

    requires: frozenset[str]

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        """Return the tensors of this frame that the next frame's `forward` needs."""
        return ()

    @abstractmethod
    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None: ...


@final
class MotionVectors(Flow):
    """The renderer's motion vectors, which are free of jitter (`supersampling.frames`): equation 1 is applied there."""

    requires = frozenset({"motion"})

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        return frame.motion


@final
class JitteredMotionVectors(Flow):
    """Motion vectors that still contain the jitter, as in some captures; equation 1 removes it here."""

    requires = frozenset({"motion", "jitter"})

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        return (frame.need("jitter"),)

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        motion, jitter = frame.need("motion", "jitter")
        return compensate_jitter(motion, jitter, *memory)


class Estimated(Flow):
    """Optical flow between the two frames' low-resolution colours, for the row "(-) MVs, (+) RAFT" of table 3.

    It has no gradient. The images are jittered, so equation 1 is applied afterwards.
    """

    requires = frozenset({"color", "jitter"})

    def remember(self, frame: Frame) -> tuple[Tensor, ...]:
        return frame.need("color", "jitter")

    @torch.no_grad()
    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        color, jitter = frame.need("color", "jitter")
        previous_color, previous_jitter = memory
        _, _, h, w = color.shape
        pixels = self.estimate(color, previous_color)
        return compensate_jitter(pixels / pixels.new_tensor((w, h)).view(2, 1, 1), jitter, previous_jitter)

    @abstractmethod
    def estimate(self, current: Tensor, previous: Tensor) -> Tensor:
        """Return the flow ``(B, 2, h, w)``, (x, y) in pixels, between colours ``(B, 3, h, w)``.

        ``current(p) = previous(p + flow(p))``.
        """


@final
class TVL1(Estimated):
    """TV-L1 (Zach et al. 2007) on luma, by scikit-image; unlike the paper's RAFT it needs no trained weights.

    It runs on the processor, item by item, and cannot be exported. Images with fewer than 4 pixels per side count as
    still.
    """

    def estimate(self, current: Tensor, previous: Tensor) -> Tensor:
        b, _, h, w = current.shape
        if min(h, w) < SMALLEST:
            return current.new_zeros(b, 2, h, w)
        # (row, column) in pixels: reference(p) = moving(p + flow)
        flows = np.stack([optical_flow_tvl1(*pair)[::-1] for pair in zip(_luma(current), _luma(previous))])
        return torch.from_numpy(flows).to(current)


@final
class RAFT(Estimated):
    """RAFT (Teed and Deng 2020) by torchvision, with weights trained on Sintel: the paper's choice.

    The network is frozen and evaluates in float32. Its weights are buffers that are not saved: they follow the device,
    but they are not parameters of the method, neither for an optimizer nor in a checkpoint nor in a count.

    Items go through the network one by one: where an image is flat, its instance normalisation amplifies rounding,
    which depends on the batch size. Sides must be multiples of 8 and at least 128 pixels: an image whose longer side is
    shorter is enlarged bilinearly by an integer factor, and the mean flow of each block is taken; for the rest the
    borders are repeated, half on each side.

    Args:
        network: ``raft_large`` or ``raft_small``, as torchvision names them.
        weights: one of torchvision's names of weights for this network.
        updates: number of updates of the flow, at least 1; torchvision's default is 12, and the paper does not say.
    """

    def __init__(self, network: str, weights: str, updates: int) -> None:
        super().__init__()
        if network not in RAFTS:
            raise UserError(f"Unknown flow.network={network}: use {' or '.join(RAFTS)}.")
        if updates < 1:
            raise UserError(f"Invalid flow.updates={updates}: use at least 1; torchvision's default is 12.")
        self.network, self.updates = get_model(network, weights=None), updates
        load_pretrained(self.network, network, weights, "model/flow=raft", "use model/flow=tvl1")
        _freeze(self.network)

    def train(self, mode: bool = True) -> "RAFT":
        super().train(mode)
        self.network.eval()  # otherwise its batch normalisation would adapt
        return self

    def estimate(self, current: Tensor, previous: Tensor) -> Tensor:
        _, _, h, w = current.shape
        factor = max(1, -(-RAFT_SMALLEST // max(h, w)))
        left, right = _margins(w * factor)
        top, bottom = _margins(h * factor)

        def prepare(image: Tensor) -> Tensor:
            large = F.interpolate(image.float(), scale_factor=factor, mode="bilinear", align_corners=False)
            return F.pad(2.0 * large - 1.0, (left, right, top, bottom), mode="replicate")

        pairs = zip(prepare(current).split(1), prepare(previous).split(1))
        with torch.autocast(current.device.type, enabled=False):
            flow = torch.cat([self.network(*pair, self.updates)[-1] for pair in pairs])
        inside = flow[..., top : top + h * factor, left : left + w * factor]
        return (F.avg_pool2d(inside, factor) / factor).to(current.dtype)


def _margins(size: int) -> tuple[int, int]:
    """Return the padding in front of a side of ``size`` pixels and behind it, to a length that RAFT accepts."""
    padding = max(RAFT_SMALLEST, -(-size // RAFT_BLOCK) * RAFT_BLOCK) - size
    return padding // 2, padding - padding // 2


def _freeze(network: nn.Module) -> None:
    """Turn all parameters and buffers into buffers that are not saved."""
    for module in network.modules():
        for name, values in [*module.named_parameters(recurse=False), *module.named_buffers(recurse=False)]:
            delattr(module, name)
            module.register_buffer(name, values.detach(), persistent=False)


def _luma(color: Tensor) -> np.ndarray:
    weights = color.new_tensor(LUMA).view(3, 1, 1)
    luma: np.ndarray = (color * weights).sum(dim=1).float().cpu().numpy()
    return luma


@final
class NoFlow(Flow):
    """No motion: the history stays in place; the row "(-) warping" of table 3."""

    requires = frozenset[str]()

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        return None
