"""DLCTUS: a network controls history rectification and accumulation (Swensen 2021, chapter 4 and appendix A.1)."""

from abc import ABC
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale, jitter_aligned_upsample, upsample_motion, zero_upsample
from supersampling.stages.accumulate import Accumulate
from supersampling.stages.confine import Confine
from supersampling.stages.dilate import Dilate
from supersampling.stages.gate import OPEN, SHUT, Gate, bias_at
from supersampling.stages.initialise import Initialise
from supersampling.stages.pad import Pad
from supersampling.stages.reproject import Reproject

STRIDE = 4  # of the network, at every scale
WIDTH = 2 * STRIDE**2  # so that the pixel shuffle leaves the two outputs o1 and o2


def pad_to_blocks(x: Tensor) -> Tensor:
    """Repeat the last row and column of ``(B, C, H, W)`` until 4 divides both sides."""
    below, right = -x.shape[-2] % STRIDE, -x.shape[-1] % STRIDE
    return F.pad(x, (0, right, 0, below), mode="replicate") if below or right else x


class ResidualBlock(nn.Sequential):
    """Two 3x3 convolutions with a ReLU between, added to their input (figure 5): ``(B, 32, h, w)`` on both sides."""

    def __init__(self) -> None:
        super().__init__(
            nn.Conv2d(WIDTH, WIDTH, 3, padding=1, padding_mode="replicate"),
            nn.ReLU(inplace=True),
            nn.Conv2d(WIDTH, WIDTH, 3, padding=1, padding_mode="replicate"),
        )

    def forward(self, input: Tensor) -> Tensor:
        return input + super().forward(input)


class Trunk(nn.Module):
    """The network of figure 5: ``(B, C, H, W) -> (B, 2, H, W)``, of any size; 78,112 parameters at C = 8.

    An input whose size is not a multiple of 4 is padded by repeating the last row and column, and the output is
    cropped.
    """

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.down = nn.Conv2d(channels, WIDTH, STRIDE, stride=STRIDE)
        self.blocks = nn.ModuleList(ResidualBlock() for _ in range(4))
        self.up = nn.PixelShuffle(STRIDE)

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        x = self.down(pad_to_blocks(x))
        for block in self.blocks:
            x = block(x)
        return self.up(x)[..., :height, :width]

    def output_layers(self) -> list[nn.Conv2d]:
        """Return the last convolution of every residual block: with ``down``, the layers whose sum is the output."""
        return [block[-1] for block in self.blocks]  # type: ignore[index]


class Blending(Upsampler[Tensor], ABC):
    """DLCTUS without its network: the common part of the plain form and of the one for inference.

    The state is the history ``(B, C, H, W)``: colour and, with an accumulation buffer, a fourth channel in [0, 1].
    """

    def __init__(
        self, scale: int, reproject: Reproject, dilate: Dilate, pad: Pad, accumulate: Accumulate, confine: Confine
    ) -> None:
        super().__init__()
        self.scale = check_scale(scale)
        self.reproject, self.dilate, self.pad = reproject, dilate, pad
        self.accumulate, self.confine = accumulate, confine
        self.requires = frozenset({"color", "depth", "jitter", "motion"}) | dilate.requires

    def samples(self, frame: Frame) -> tuple[Tensor, Tensor]:
        """Return the input of zero upsampling (4.1.1): colour and depth ``(B, 4, h, w)``, and jitter ``(B, 2)``."""
        color, depth, jitter = frame.need("color", "depth", "jitter")
        return torch.cat((color, depth), dim=1), jitter

    def prepare(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        """Return the jitter-aligned input and the reprojected, padded history, both ``(B, C, H, W)`` (4.1.1, 4.1.2)."""
        color, jitter, motion = frame.need("color", "jitter", "motion")
        # The buffer's channel is 1 everywhere, and interpolated ones are ones, so it is appended afterwards.
        aligned = self.accumulate.append(jitter_aligned_upsample(color, jitter, self.scale))
        if state is None:
            return aligned, aligned
        height, width = aligned.shape[-2:]
        motion = upsample_motion(self.dilate(motion, frame.depth), (height, width))
        return aligned, self.pad(self.reproject(state, motion), aligned, motion)

    def prepare_input(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor, Tensor]:
        """Return the network's input, and what `prepare` returns: the thesis's input preparation (4.4.1)."""
        sparse = zero_upsample(*self.samples(frame), self.scale)
        aligned, history = self.prepare(frame, state)
        return torch.cat((sparse, history), dim=1), aligned, history

    def construct(self, aligned: Tensor, history: Tensor, predicted: Tensor) -> Tensor:
        """Return the new history (4.1.4), ``(B, C, ...)`` like the old one, from the network's output ``(B, 2, ...)``.

        It stays in full precision under autocast, because rounding errors would add up over frames.
        """
        o1, o2 = self.confine(predicted.to(history.dtype)).split(1, dim=1)
        return self.accumulate(torch.lerp(history, aligned, o1), o2).clamp(0.0, 1.0)

    def state_images(self, state: Tensor) -> dict[str, Tensor]:
        return self.accumulate.state_images(state)


def _bias_of_o1(model: "DLCTUS") -> Tensor | None:
    bias = model.network.output_layers()[-1].bias
    return None if bias is None else bias[: STRIDE**2]


def _bias_of_o2(model: "DLCTUS") -> Tensor | None:
    bias = model.network.output_layers()[-1].bias
    return None if bias is None else bias[STRIDE**2 :]


@final
class DLCTUS(Blending):
    """Network-controlled blending of reprojected history and jitter-aligned input.

    ``o1`` is the network's blending weight (eq 44), ``o2`` its factor on the accumulation buffer (eq 45).

    Args:
        scale: ``s``.
        reproject, dilate, pad, accumulate, confine: stages.
        initialise: called once on the new network.
    """

    extremes = (
        Gate("gate/o1 0", "DLCTUS: nothing of the input is blended in.", bias_at(SHUT, _bias_of_o1)),
        Gate("gate/o1 1", "DLCTUS: nothing of the history is kept.", bias_at(OPEN, _bias_of_o1)),
        Gate("gate/accumulation 0", "DLCTUS: o2 is 0, the accumulation buffer is emptied.", bias_at(SHUT, _bias_of_o2)),
        Gate(
            "gate/accumulation 1", "DLCTUS: o2 is 1, the accumulation buffer never decays.", bias_at(OPEN, _bias_of_o2)
        ),
    )

    def __init__(
        self,
        scale: int,
        reproject: Reproject,
        dilate: Dilate,
        pad: Pad,
        accumulate: Accumulate,
        confine: Confine,
        initialise: Initialise,
    ) -> None:
        super().__init__(scale, reproject, dilate, pad, accumulate, confine)
        self.network = Trunk(4 + accumulate.channels)
        initialise(self.network.down, self.network.output_layers(), confine)

    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        x, aligned, history = self.prepare_input(frame, state)
        history = self.construct(aligned, history, self.network(x))
        return history[:, :3], history

    def for_inference(self) -> Upsampler[Tensor]:
        """Return a copy with the thesis's two rewrites (4.4.4): the same outputs and states up to rounding."""
        from supersampling.models.dlctus_inference import DLCTUSForInference

        return DLCTUSForInference(self)
