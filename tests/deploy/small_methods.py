"""Methods of a few operations, each with something that makes an export go wrong."""

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
    """A state that holds the same tensor twice, an input itself, and a tensor without image axes; its own `present`."""

    scale = 2
    requires = frozenset({"color", "motion", "jitter", "high_albedo"})

    def __init__(self) -> None:
        super().__init__()
        self.mix = nn.Conv2d(9, 3, 3, padding=1)

    def forward(self, frame: Frame, state: Memory | None) -> tuple[Tensor, Memory]:
        color, motion, jitter = frame.need("color", "motion", "jitter")
        if state is None:
            state = Memory((color, color), jitter, color.mean(dim=(2, 3)))
        moved = warp(state.window[0], motion)
        mixed = self.mix(torch.cat((color, moved, state.window[1]), dim=1)).sigmoid()
        shift = (jitter - state.jitter).sum(dim=1)[:, None, None, None]
        mean = 0.9 * state.mean + 0.1 * mixed.mean(dim=(2, 3))
        output = F.interpolate(mixed + 0.1 * shift + mean[..., None, None], scale_factor=2.0)
        return output, Memory((mixed, state.window[0]), jitter, mean)

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return (0.5 * output * frame.need("high_albedo")).clamp(0.0, 1.0)


class Even(Upsampler[tuple[()]]):
    """No state, and a branch on the size: half the brightness unless ``pair`` divides rows and columns."""

    scale = 2
    requires = frozenset({"color"})

    def __init__(self, pair: int) -> None:
        super().__init__()
        self.pair = pair

    def forward(self, frame: Frame, state: tuple[()] | None) -> tuple[Tensor, tuple[()]]:
        color = frame.need("color")
        if any(n % self.pair for n in color.shape[-2:]):
            return F.interpolate(color, scale_factor=2.0) * 0.5, ()
        return F.interpolate(color, scale_factor=2.0), ()


class Growing(Upsampler[tuple[Tensor, ...]]):
    """A state that grows by one frame with each frame."""

    scale = 2
    requires = frozenset({"color"})

    def forward(self, frame: Frame, state: tuple[Tensor, ...] | None) -> tuple[Tensor, tuple[Tensor, ...]]:
        window = torch.cat((*(state or ()), frame.need("color")), dim=1)
        return F.interpolate(window[:, :3], scale_factor=2.0), (window,)
