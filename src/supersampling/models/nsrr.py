"""NSRR: zero-upsampled previous frames, warped at the target resolution, reweighted, fused by a U-Net (Xiao et al. 2020).

Symbols: ``n`` previous frames, ``C`` feature channels of a frame (12: 3 colour, 1 depth, 8 learned).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale
from supersampling.stages.colour_space import ColourSpace
from supersampling.stages.extract import Extract
from supersampling.stages.reweight import RGBD, Reweight
from supersampling.stages.upsample import Upsample
from supersampling.stages.warp_at import State, WarpAt

SHRINK = 4  # of the U-Net's coarsest scale


class UNet(nn.Module):
    """Ten convolutions 3x3 at three scales, 64-32, 64-64, 128-128, 64-64, 32-3 (figure 4, blue), any size from 1x1 up.

    ``(B, channels, H, W) -> (B, 3, H, W)``. The text leaves open what lies between them: 2x2 max pooling downwards, bilinear
    interpolation upwards, a scale's last features concatenated after the upsampled ones, ReLU after every convolution but the
    last. A size that is no multiple of 4 is padded with zeros to the right and below, and the output cropped.
    """

    def __init__(self, channels: int, width: int = 64) -> None:
        super().__init__()
        if width < 2 or width % 2:
            raise UserError(
                f"model.width must be an even number from 2 up, got {width}; the paper has 64 and 32."
            )
        half = width // 2
        self.fine = _pair(channels, width, half)
        self.middle = _pair(half, width, width)
        self.coarse = _pair(width, 2 * width, 2 * width)
        self.to_middle = _pair(3 * width, width, width)
        self.to_fine = nn.Sequential(
            nn.Conv2d(width + half, half, 3, padding=1),
            nn.ReLU(inplace=True),
            nn.Conv2d(half, 3, 3, padding=1),
        )

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        below, right = -height % SHRINK, -width % SHRINK
        if below or right:
            x = F.pad(x, (0, right, 0, below))
        fine = self.fine(x)
        middle = self.middle(F.max_pool2d(fine, 2))
        coarse = self.coarse(F.max_pool2d(middle, 2))
        middle = self.to_middle(torch.cat((_double(coarse), middle), dim=1))
        return self.to_fine(torch.cat((_double(middle), fine), dim=1))[..., :height, :width]


class Previous(nn.Module, ABC):
    """What the reconstruction reads beside the current frame; ``channels`` of it in all."""

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def forward(
        self, current: Tensor, samples: Tensor, frame: Frame, state: State | None
    ) -> tuple[Tensor, State]:
        """``current (B, C, H, W)`` with the previous frames appended, and the new state.

        ``samples (B, 4, h, w)`` are this frame's inputs, which become a previous frame's features.
        """


@final
class NoPreviousFrames(Previous):
    """No previous frame, an empty state (table 5, figure 9)."""

    requires = frozenset[str]()

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.channels = channels

    def forward(
        self, current: Tensor, samples: Tensor, frame: Frame, state: State | None
    ) -> tuple[Tensor, State]:
        return current, ()


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

    def forward(
        self, current: Tensor, samples: Tensor, frame: Frame, state: State | None
    ) -> tuple[Tensor, State]:
        assert frame.motion is not None
        assert frame.jitter is not None
        newest = self.warp_at.enter(self.extract(samples), frame.jitter, self.scale, self.upsample)
        if state is None:
            window = newest.repeat(1, self.previous, 1, 1)
        else:
            window = self.warp_at(state, frame.motion, frame.jitter)
        past = self.warp_at.leave(window, frame.jitter, self.scale, self.upsample)
        past = self.reweight(current, past.unflatten(1, (self.previous, -1)))
        window = torch.cat((newest, window[:, : (self.previous - 1) * newest.shape[1]]), dim=1)
        return torch.cat((current, past.flatten(1, 2)), dim=1), self.warp_at.keep(window, frame.jitter)


@final
class NSRR(Upsampler[State]):
    """A network that sees the current frame and ``n`` previous ones, warped to it, at the target resolution (figure 4).

    The state is the window of previous frames ``(B, n * C, ., .)``, newest first, as seen from the last of them and at the
    resolution that they are warped at, with what else ``warp_at`` keeps; empty where ``n`` is 0. Outputs are in the stage
    ``colour_space``, unbounded. The text converts "the input RGB image of current frame" (3.2.5): every frame here, when it
    arrives, so that the window holds one space. Weights start as in Glorot and Bengio 2010, uniform, biases at zero (3.4).

    531,061 parameters with 2 previous frames, 547,767 with 4.

    Args:
        scale: ``s``.
        previous: ``n``, 0 or more; the paper has up to 4.
        width: the U-Net's, 64; 32 is the paper's "Ours-Fast" (4.1), which halves all its layers but the last.
        extract: called with the number of inputs, for the current frame and, with other weights, for all previous ones.
        reweight: called with ``previous``.
        warp_at, upsample, colour_space: stages.
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
    ) -> None:
        super().__init__()
        if int(previous) != previous or previous < 0:
            raise UserError(
                f"model.previous must be a whole number from 0 up, got {previous}; the paper has 0 to 4."
            )
        self.scale = check_scale(scale)
        self.extract, self.upsample, self.colour_space = extract(RGBD), upsample, colour_space
        self.previous_frames: Previous = NoPreviousFrames(self.extract.channels)
        if previous:
            self.previous_frames = PreviousFrames(
                previous, self.scale, extract(RGBD), reweight(previous), warp_at, upsample
            )
        self.reconstruct = UNet(self.previous_frames.channels, width)
        self.requires = frozenset({"color", "depth", "jitter"}) | self.previous_frames.requires
        self.apply(_glorot)

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return self.colour_space.of_rgb(clip["target"])

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return self.colour_space.to_rgb(output).clamp(0.0, 1.0)

    def forward(self, frame: Frame, state: State | None) -> tuple[Tensor, State]:
        assert frame.color is not None
        assert frame.depth is not None
        assert frame.jitter is not None
        samples = torch.cat((self.colour_space.of_rgb(frame.color), frame.depth), dim=1)
        current = self.upsample(self.extract(samples), frame.jitter, self.scale)
        features, state = self.previous_frames(current, samples, frame, state)
        return self.reconstruct(features), state


def _pair(channels: int, first: int, second: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(channels, first, 3, padding=1),
        nn.ReLU(inplace=True),
        nn.Conv2d(first, second, 3, padding=1),
        nn.ReLU(inplace=True),
    )


def _double(x: Tensor) -> Tensor:
    return F.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)


def _glorot(module: nn.Module) -> None:
    if isinstance(module, nn.Conv2d):
        nn.init.xavier_uniform_(module.weight)
        assert module.bias is not None
        nn.init.zeros_(module.bias)
