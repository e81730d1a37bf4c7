"""Slot ``flow``: how the motion from the current to the previous frame is known (Mercier et al. 2023, section 4.1, "Jitter
compensation", and section 6.2)."""

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
from supersampling.ops.pretrained import load_pretrained
from supersampling.ops.resample import jitter_as_motion

LUMA = (0.2126, 0.7152, 0.0722)  # Rec. 709
SMALLEST = 4  # pixels a side; below, TV-L1 has no neighbourhood to work on
RAFTS = ("raft_large", "raft_small")
RAFT_BLOCK, RAFT_SMALLEST = 8, 128  # pixels that a side is a multiple of, and at least


def compensate_jitter(motion: Tensor, jitter: Tensor, previous: Tensor) -> Tensor:
    """``MV_t + J_{t-1} - J_t`` (eq 1): motion between two jittered images without what the jitter adds to it.

    Args:
        motion: ``(B, 2, h, w)``, backward, units of the image: where a pixel's sample lies in the previous image.
        jitter, previous: ``(B, 2)`` of this frame and the previous one, low-resolution pixels.
    """
    h, w = motion.shape[-2:]
    return motion + jitter_as_motion(previous - jitter, h, w)


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
        return (frame.need("jitter"),)

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        motion, jitter = frame.need("motion", "jitter")
        return compensate_jitter(motion, jitter, *memory)


class Estimated(Flow):
    """Optical flow of the two frames' low-resolution colour, for the row "(-) MVs, (+) RAFT" of table 3. It gives no gradient.

    The images are jittered, so equation 1 follows.
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
    def estimate(self, now: Tensor, before: Tensor) -> Tensor:
        """``(B, 2, h, w)``, (x, y) in pixels, of colours ``(B, 3, h, w)``: ``now(p) = before(p + flow(p))``."""


@final
class TVL1(Estimated):
    """By scikit-image from luma; TV-L1 (Zach et al. 2007) needs no trained weights, as the paper's RAFT does.

    It runs on the processor, item by item, and does not export. Images below 4 pixels a side count as still.
    """

    def estimate(self, now: Tensor, before: Tensor) -> Tensor:
        b, _, h, w = now.shape
        if min(h, w) < SMALLEST:
            return now.new_zeros(b, 2, h, w)
        # (row, column) in pixels: reference(p) = moving(p + flow)
        flows = np.stack([optical_flow_tvl1(a, b)[::-1] for a, b in zip(_luma(now), _luma(before))])
        return torch.from_numpy(flows).to(now)


@final
class RAFT(Estimated):
    """By torchvision's RAFT (Teed and Deng 2020), which is what the paper has, with weights that have seen Sintel, as there.

    The network is frozen and evaluates in float32. Its weights are buffers that are not saved: they follow the device, and are no
    parameters of the method, neither for an optimizer nor in a checkpoint nor in a count.

    Items go through it one by one: where an image is flat, its instance normalisation enlarges the rounding that a batch's size
    changes. It wants sides that are multiples of 8 and at least 128 pixels: images whose longer side is shorter are enlarged
    bilinearly by a whole factor, whose blocks' mean flow counts, and borders are repeated for the rest, half on each side.

    Args:
        network: ``raft_large`` or ``raft_small``, torchvision's names.
        weights: a name among torchvision's for it.
        updates: of the flow, 1 or more; torchvision's own number is 12, the paper is silent.
    """

    def __init__(self, network: str, weights: str, updates: int) -> None:
        super().__init__()
        if network not in RAFTS:
            raise UserError(f"flow.network={network} is no RAFT of torchvision: use {' or '.join(RAFTS)}.")
        if updates < 1:
            raise UserError(f"flow.updates must be 1 or more, got {updates}; torchvision has 12.")
        self.network, self.updates = get_model(network, weights=None), updates
        load_pretrained(self.network, network, weights, "model/flow=raft", "use model/flow=tvl1")
        _freeze(self.network)

    def train(self, mode: bool = True) -> "RAFT":
        super().train(mode)
        self.network.eval()  # else its batch normalisation would learn
        return self

    def estimate(self, now: Tensor, before: Tensor) -> Tensor:
        _, _, h, w = now.shape
        factor = max(1, -(-RAFT_SMALLEST // max(h, w)))
        left, right = _margins(w * factor)
        top, bottom = _margins(h * factor)

        def prepared(image: Tensor) -> Tensor:
            large = F.interpolate(image.float(), scale_factor=factor, mode="bilinear", align_corners=False)
            return F.pad(2.0 * large - 1.0, (left, right, top, bottom), mode="replicate")

        pairs = zip(prepared(now).split(1), prepared(before).split(1))
        with torch.autocast(now.device.type, enabled=False):
            flow = torch.cat([self.network(*pair, self.updates)[-1] for pair in pairs])
        inside = flow[..., top : top + h * factor, left : left + w * factor]
        return (F.avg_pool2d(inside, factor) / factor).to(now.dtype)


def _margins(size: int) -> tuple[int, int]:
    """What RAFT lacks of a side, before and after it."""
    lacking = max(RAFT_SMALLEST, -(-size // RAFT_BLOCK) * RAFT_BLOCK) - size
    return lacking // 2, lacking - lacking // 2


def _freeze(network: nn.Module) -> None:
    """Make buffers that are not saved of all parameters and buffers."""
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
    """The history stays in place, no motion is read: the row "(-) warping" of table 3."""

    requires = frozenset[str]()

    def forward(self, frame: Frame, memory: tuple[Tensor, ...]) -> Tensor | None:
        return None
