"""Methods of a few operations, each with what makes an export go wrong."""

from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.warp import warp


class Memory(NamedTuple):
    window: tuple[Tensor, ...]
    jitter: Tensor
    mean: Tensor


class Aliasing(Upsampler[Memory]):
    """A state of one tensor twice, of an input itself, and of one that no image's size is in; a present of its own."""

    scale = 2
    requires = frozenset({"color", "motion", "jitter", "high_albedo"})

    def __init__(self) -> None:
        super().__init__()
        self.mix = nn.Conv2d(9, 3, 3, padding=1)

    def forward(self, frame: Frame, state: Memory | None) -> tuple[Tensor, Memory]:
        color, motion, jitter = frame.color, frame.motion, frame.jitter
        assert color is not None
        assert motion is not None
        assert jitter is not None
        if state is None:
            state = Memory((color, color), jitter, color.mean(dim=(2, 3)))
        moved = warp(state.window[0], motion)
        mixed = self.mix(torch.cat((color, moved, state.window[1]), dim=1)).sigmoid()
        shift = (jitter - state.jitter).sum(dim=1)[:, None, None, None]
        mean = 0.9 * state.mean + 0.1 * mixed.mean(dim=(2, 3))
        output = F.interpolate(mixed + 0.1 * shift + mean[..., None, None], scale_factor=2.0)
        return output, Memory((mixed, state.window[0]), jitter, mean)

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        assert frame.high_albedo is not None
        return (0.5 * output * frame.high_albedo).clamp(0.0, 1.0)


class Even(Upsampler[tuple[()]]):
    """No state, and a branch on the size: rows and columns in pairs, else something else."""

    scale = 2
    requires = frozenset({"color"})

    def __init__(self, pair: int) -> None:
        super().__init__()
        self.pair = pair

    def forward(self, frame: Frame, state: tuple[()] | None) -> tuple[Tensor, tuple[()]]:
        assert frame.color is not None
        if any(n % self.pair for n in frame.color.shape[-2:]):
            return F.interpolate(frame.color, scale_factor=2.0) * 0.5, ()
        return F.interpolate(frame.color, scale_factor=2.0), ()


class Growing(Upsampler[tuple[Tensor, ...]]):
    """A state that has one frame more after every frame."""

    scale = 2
    requires = frozenset({"color"})

    def forward(self, frame: Frame, state: tuple[Tensor, ...] | None) -> tuple[Tensor, tuple[Tensor, ...]]:
        assert frame.color is not None
        window = torch.cat((*(state or ()), frame.color), dim=1)
        return F.interpolate(window[:, :3], scale_factor=2.0), (window,)
