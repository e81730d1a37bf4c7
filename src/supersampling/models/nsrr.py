"""NSRR: zero-upsampled previous frames, warped at target resolution, reweighted, fused by a U-Net (Xiao et al. 2020).

Symbols: ``n`` previous frames, ``C`` feature channels of a frame (12: 3 colour, 1 depth, 8 learned; guides follow
depth).
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
    """The part of the reconstruction's input that comes from previous frames.

    ``channels`` counts the whole input, including the current frame; ``requires`` names the buffers that are read.
    """

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def forward(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        """Return ``current (B, C, H, W)`` with the previous frames appended, and the new state.

        ``samples (B, ., h, w)`` are this frame's inputs, which become a previous frame's features.
        """

    @abstractmethod
    def advance(self, samples: Tensor, frame: Frame, state: State | None) -> State:
        """Return the new state only."""

    @abstractmethod
    def images(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> dict[str, Tensor]:
        """Return what is worth looking at by name, ``(B, 1, H, W)`` in [0, 1]; arguments as in `forward`."""


@final
class NoPreviousFrames(Previous):
    """No previous frame and an empty state (table 5, figure 9)."""

    requires = frozenset[str]()

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.channels = channels

    def forward(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        return current, ()

    def advance(self, samples: Tensor, frame: Frame, state: State | None) -> State:
        return ()

    def images(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> dict[str, Tensor]:
        return {}


@final
class PreviousFrames(Previous):
    """Features of ``n`` previous frames, warped to the current one and reweighted (3.2.1 to 3.2.3).

    The paper warps a frame's features "iteratively until each previous frame is warped to the current one": frame
    ``t - k`` to ``t - k + 1`` by that frame's motion, and so on to ``t``. All of these warps except the last were
    computed when the frames in between were current, so the state holds the window as it was warped then, and one warp
    of the whole window by the newest motion completes it: the same numbers with one warp per step. Features of a frame
    are extracted once, when it arrives.

    A clip's first frame stands in for the frames before it, as if nothing had moved until then: the paper does not say,
    and training on full windows has not shown the network any other case.
    """

    requires = frozenset({"motion"})

    def __init__(
        self, previous: int, scale: int, extract: Extract, reweight: Reweight, warp_at: WarpAt, upsample: Upsample
    ) -> None:
        super().__init__()
        self.previous, self.scale = previous, scale
        self.extract, self.reweight, self.warp_at, self.upsample = extract, reweight, warp_at, upsample
        self.channels = (previous + 1) * extract.channels

    def forward(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        window, state = self._warp_window(samples, frame, state)
        past = self.reweight(current, self._past(window, frame))
        return torch.cat((current, past.flatten(1, 2)), dim=1), state

    def advance(self, samples: Tensor, frame: Frame, state: State | None) -> State:
        return self._warp_window(samples, frame, state)[1]

    def images(self, current: Tensor, samples: Tensor, frame: Frame, state: State | None) -> dict[str, Tensor]:
        window, _ = self._warp_window(samples, frame, state)
        return self.reweight.images(current, self._past(window, frame))

    def _past(self, window: Tensor, frame: Frame) -> Tensor:
        """Return the warped previous frames ``(B, n, C, H, W)`` at target resolution."""
        past = self.warp_at.leave(window, frame.need("jitter"), self.scale, self.upsample)
        return past.unflatten(1, (self.previous, -1))

    def _warp_window(self, samples: Tensor, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        """Return the window warped to this frame, and the new state, with this frame in front."""
        motion, jitter = frame.need("motion", "jitter")
        newest = self.warp_at.enter(self.extract(samples), jitter, self.scale, self.upsample)
        if state is None:
            window = newest.repeat(1, self.previous, 1, 1)
        else:
            window = self.warp_at(state, motion, jitter)
        following = torch.cat((newest, window[:, : (self.previous - 1) * newest.shape[1]]), dim=1)
        return window, self.warp_at.keep(following, jitter)


@final
class NSRR(Upsampler[State]):
    """A network on the current frame and ``n`` previous ones, warped to it, at the target resolution (figure 4).

    The state is the window of previous frames ``(B, n * C, ., .)``, newest first, warped to the last of them, at the
    resolution of ``warp_at``, with what else that stage keeps; it is empty if ``n`` is 0. Outputs are in the domain of
    the stage ``demodulate`` (display colour, or light), in the space of the stage ``colour_space``, unbounded. The text
    converts "the input RGB image of current frame" (3.2.5): here every frame is converted when it arrives, so that the
    window has one colour space. Weights start as in Glorot and Bengio 2010, uniform, biases at zero (3.4).

    531,061 parameters with 2 previous frames, 547,767 with 4. Each channel of the stage ``guides`` adds one to ``C``.

    Args:
        scale: ``s``.
        previous: ``n``, at least 0; the paper has up to 4.
        width: the U-Net's, 64; 32 is the paper's "Ours-Fast" (4.1), which halves all layers except the last.
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
            raise UserError(f"Invalid model.previous={previous}: use a whole number, at least 0; the paper has 0 to 4.")
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

    def step_images(self, frame: Frame, state: State | None) -> dict[str, Tensor]:
        samples = self._samples(frame)
        current = self.upsample(self.extract(samples), frame.need("jitter"), self.scale)
        return self.previous_frames.images(current, samples, frame, state)

    def _samples(self, frame: Frame) -> Tensor:
        """Return this frame's inputs ``(B, 4 + guides, h, w)``: colour, depth, guides."""
        depth = frame.need("depth")
        # Lighting has at least float32; a network of weights in bfloat16 reads bfloat16.
        color = self.colour_space.of_rgb(self.demodulate(frame)).to(depth.dtype)
        return self.guides(torch.cat((color, depth), dim=1), frame)


def _glorot(module: nn.Module) -> None:
    if isinstance(module, nn.Conv2d):
        nn.init.xavier_uniform_(module.weight)
        assert module.bias is not None
        nn.init.zeros_(module.bias)
