"""NSRR: zero-upsampled previous frames, warped at the target resolution, reweighted, fused by a U-Net (Xiao et al. 2020).

Symbols: ``n`` previous frames, ``C`` feature channels of a frame (12: 3 colour, 1 depth, 8 learned; guides come after depth).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.blocks.unet import UNet
from supersampling.ops.resample import check_scale
from supersampling.stages.base import Base
from supersampling.stages.colour_space import ColourSpace
from supersampling.stages.demodulate import Demodulate
from supersampling.stages.extract import Extract
from supersampling.stages.guides import Guides
from supersampling.stages.reweight import RGBD, Reweight
from supersampling.stages.upsample import Upsample
from supersampling.stages.warp_at import State, WarpAt


class Previous(nn.Module, ABC):
    """What the reconstruction reads beside the current frame; ``channels`` of it in all."""

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def forward(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        """``current (B, C, H, W)`` with the previous frames appended, and the new state.

        ``samples (B, ., h, w)`` are this frame's inputs, which become a previous frame's features.
        """

    @abstractmethod
    def advance(self, samples: Tensor, frame: Frame, state: State | None) -> State:
        """The new state alone."""


@final
class NoPreviousFrames(Previous):
    """No previous frame, an empty state (table 5, figure 9)."""

    requires = frozenset[str]()

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.channels = channels

    def forward(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        return current, ()

    def advance(self, samples: Tensor, frame: Frame, state: State | None) -> State:
        return ()


@final
class PreviousFrames(Previous):
    """Features of ``n`` previous frames, warped to the current one and reweighted (3.2.1 to 3.2.3).

    The paper warps a frame's features "iteratively until each previous frame is warped to the current one": frame ``t - k``
    to ``t - k + 1`` by that frame's motion, and so on to ``t``. All of these warps but the last were made when the frames in
    between were current, so the state holds the window as it was warped then, and one warp of the whole window, by the newest
    motion, does the rest: the same numbers for one warp a step. Each frame is extracted once, when it arrives.

    A clip's first frame stands in for the frames before it, as if all had stood still until then: the paper is silent, and
    training on full windows has shown the network nothing else.
    """

    requires = frozenset({"motion"})

    def __init__(
        self,
        previous: int,
        scale: int,
        extract: Extract,
        reweight: Reweight,
        warp_at: WarpAt,
        upsample: Upsample,
    ) -> None:
        super().__init__()
        self.previous, self.scale = previous, scale
        self.extract, self.reweight, self.warp_at, self.upsample = extract, reweight, warp_at, upsample
        self.channels = (previous + 1) * extract.channels

    def forward(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        window, state = self._see(samples, frame, state)
        past = self.warp_at.leave(window, frame.need("jitter"), self.scale, self.upsample)
        past = self.reweight(current, past.unflatten(1, (self.previous, -1)))
        return torch.cat((current, past.flatten(1, 2)), dim=1), state

    def advance(self, samples: Tensor, frame: Frame, state: State | None) -> State:
        return self._see(samples, frame, state)[1]

    def _see(self, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        """The window as seen from this frame, and the state that has this frame in front."""
        motion, jitter = frame.need("motion", "jitter")
        newest = self.warp_at.enter(self.extract(samples), jitter, self.scale, self.upsample)
        if state is None:
            window = newest.repeat(1, self.previous, 1, 1)
        else:
            window = self.warp_at(state, motion, jitter)
        kept = torch.cat((newest, window[:, : (self.previous - 1) * newest.shape[1]]), dim=1)
        return window, self.warp_at.keep(kept, jitter)


@final
class NSRR(Upsampler[State]):
    """A network that sees the current frame and ``n`` previous ones, warped to it, at the target resolution (figure 4).

    The state is the window of previous frames ``(B, n * C, ., .)``, newest first, as seen from the last of them and at the
    resolution that they are warped at, with what else ``warp_at`` keeps; empty where ``n`` is 0. Outputs are what the stage
    ``demodulate`` says (display colour, or light), in the space of the stage ``colour_space``, unbounded. The text converts
    "the input RGB image of current frame" (3.2.5): every frame here, when it arrives, so that the window holds one space.
    Weights start as in Glorot and Bengio 2010, uniform, biases at zero (3.4).

    531,061 parameters with 2 previous frames, 547,767 with 4. Each channel of the stage ``guides`` adds one to ``C``.

    Args:
        scale: ``s``.
        previous: ``n``, 0 or more; the paper has up to 4.
        width: the U-Net's, 64; 32 is the paper's "Ours-Fast" (4.1), which halves all its layers but the last.
        extract: called with the number of inputs, for the current frame and, with other weights, for all previous ones.
        reweight: called with ``previous``.
        upsample, warp_at, colour_space, demodulate, guides, base: stages.
    """

    def __init__(
        self,
        scale: int,
        previous: int,
        width: int,
        extract: Callable[[int], Extract],
        upsample: Upsample,
        warp_at: WarpAt,
        reweight: Callable[[int], Reweight],
        colour_space: ColourSpace,
        demodulate: Demodulate,
        guides: Guides,
        base: Base,
    ) -> None:
        super().__init__()
        if int(previous) != previous or previous < 0:
            raise UserError(f"model.previous must be a whole number from 0 up, got {previous}; the paper has 0 to 4.")
        self.scale = check_scale(scale)
        self.colour_space, self.demodulate, self.guides, self.base = colour_space, demodulate, guides, base
        inputs = RGBD + guides.channels
        self.extract, self.upsample = extract(inputs), upsample
        self.previous_frames: Previous = NoPreviousFrames(self.extract.channels)
        if previous:
            self.previous_frames = PreviousFrames(
                previous, self.scale, extract(inputs), reweight(previous), warp_at, upsample
            )
        self.reconstruct = UNet(self.previous_frames.channels, width)
        read = demodulate.requires | guides.requires | base.requires | self.previous_frames.requires
        self.requires = read | {"depth", "jitter"}
        self.compares = demodulate.compares
        self.apply(_glorot)

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return self.colour_space.of_rgb(self.demodulate.reference(clip))

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return self.demodulate.present(self.colour_space.to_rgb(output), frame)

    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        return self.demodulate.radiance(self.colour_space.to_rgb(output), frame)

    def forward_state(self, frame: Frame, state: State | None) -> State:
        return self.previous_frames.advance(self._samples(frame), frame, state)

    def forward(self, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        samples = self._samples(frame)
        current = self.upsample(self.extract(samples), frame.need("jitter"), self.scale)
        features, state = self.previous_frames(current, samples, frame, state)
        return self.base(self.reconstruct(features), samples[:, :3], frame), state

    def _samples(self, frame: Frame) -> Tensor:
        """What is known of this frame, ``(B, 4 + guides, h, w)``: colour, depth, guides."""
        color = self.colour_space.of_rgb(self.demodulate(frame))
        return self.guides(torch.cat((color, frame.need("depth")), dim=1), frame)


def _glorot(module: nn.Module) -> None:
    if isinstance(module, nn.Conv2d):
        nn.init.xavier_uniform_(module.weight)
        assert module.bias is not None
        nn.init.zeros_(module.bias)
