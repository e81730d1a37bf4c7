"""DLCTUS: a network controls history rectification and accumulation (Swensen 2021, chapter 4 and appendix
A.1)."""

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
from supersampling.stages.initialise import Initialise
from supersampling.stages.pad import Pad
from supersampling.stages.reproject import Reproject

STRIDE = 4  # of the network, at every scale
WIDTH = 2 * STRIDE**2  # so that the pixel shuffle leaves the two outputs o1 and o2


class Trunk(nn.Module):
    """The network of figure 5: ``(B, C, H, W) -> (B, 2, H, W)``, any size from 1x1 up; at C = 8 it has 78,112
    parameters.

    A size that is no multiple of 4 is padded by repeating the last row and column, and the output cropped.
    """

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.down = nn.Conv2d(channels, WIDTH, STRIDE, stride=STRIDE)
        self.blocks = nn.ModuleList(
            nn.Sequential(
                nn.Conv2d(WIDTH, WIDTH, 3, padding=1, padding_mode="replicate"),
                nn.ReLU(inplace=True),
                nn.Conv2d(WIDTH, WIDTH, 3, padding=1, padding_mode="replicate"),
            )
            for _ in range(4)
        )

    def forward(self, x: Tensor) -> Tensor:
        height, width = x.shape[-2:]
        below, right = -height % STRIDE, -width % STRIDE
        if below or right:
            x = F.pad(x, (0, right, 0, below), mode="replicate")
        x = self.down(x)
        for block in self.blocks:
            x = x + block(x)
        return F.pixel_shuffle(x, STRIDE)[..., :height, :width]

    def output_layers(self) -> list[nn.Conv2d]:
        """The last convolution of every residual block: with ``down``, the layers whose sum is the output."""
        return [block[-1] for block in self.blocks]  # type: ignore[index]


@final
class DLCTUS(Upsampler[Tensor]):
    """Network-controlled blending of reprojected history and jitter-aligned input.

    The state is the history ``(B, C, H, W)``: colour and, with an accumulation buffer, a fourth channel in
    [0, 1]. ``o1`` is the network's blending weight (eq 44), ``o2`` its factor on the accumulation buffer (eq
    45).

    Args:
        scale: ``s``.
        reproject, dilate, pad, accumulate, confine: stages.
        initialise: called once on the new network.
    """

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
        super().__init__()
        self.scale = check_scale(scale)
        self.reproject, self.dilate, self.pad = reproject, dilate, pad
        self.accumulate, self.confine = accumulate, confine
        self.network = Trunk(4 + accumulate.channels)
        initialise(self.network.down, self.network.output_layers(), confine)
        self.requires = frozenset({"color", "depth", "jitter", "motion"}) | dilate.requires

    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        color, depth, jitter = frame.color, frame.depth, frame.jitter
        assert color is not None
        assert depth is not None
        assert jitter is not None
        assert frame.motion is not None

        # Input upsampling, 4.1.1. Interpolated ones are ones, so the buffer's channel is appended afterwards.
        aligned = self.accumulate.append(jitter_aligned_upsample(color, jitter, self.scale))
        sparse = zero_upsample(torch.cat((color, depth), dim=1), jitter, self.scale)

        # History reprojection, 4.1.2
        if state is None:
            history = aligned
        else:
            height, width = aligned.shape[-2:]
            motion = upsample_motion(self.dilate(frame.motion, depth), (height, width))
            history = self.pad(self.reproject(state, motion), aligned, motion)

        # Network execution, 4.1.3
        o1, o2 = self.confine(self.network(torch.cat((sparse, history), dim=1))).split(1, dim=1)

        # Output construction, 4.1.4
        history = self.accumulate(torch.lerp(history, aligned, o1), o2).clamp(0.0, 1.0)
        return history[:, :3], history
