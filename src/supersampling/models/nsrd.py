"""NSRD: super-resolution of the lighting component by a frame-recurrent network (Li et al. 2024)."""

from collections.abc import Mapping
from typing import NamedTuple, final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.blocks.attention import UShaped
from supersampling.models.blocks.gated import GatedConvolution
from supersampling.ops.chain import chain
from supersampling.ops.resample import check_scale
from supersampling.ops.warp import warp
from supersampling.stages.base import Base
from supersampling.stages.demodulate import Demodulate
from supersampling.stages.gate import OPEN, SHUT, Gate, bias_at
from supersampling.stages.locate import Locate
from supersampling.stages.motion_mask import MotionMask
from supersampling.stages.recur import MakeRecur

INPUTS = 3 + 1 + 3  # lighting, depth, normal (section 4.1)
FEATURES, WIDTH = 32, 64  # supplement, section 4.2


class History(NamedTuple):
    """NSRD's state; all tensors are batch first.

    ``inputs``: those of the latest frames, newest first, ``(B, 7, h, w)`` each, 9 channels with jitter. ``vectors``:
    from the latest frame's pixels to those of the frames before it, ``(B, V, h, w)`` each, one tensor fewer.
    ``carried``: the recurrent stage's tensors. ``located``: the tensors that `locate` remembers.
    """

    inputs: tuple[Tensor, ...]
    vectors: tuple[Tensor, ...]
    carried: tuple[Tensor, ...]
    located: tuple[Tensor, ...]


class Reconstruction(nn.Module):
    """The U-shaped module, two convolutions and pixel shuffle: ``(B, 64, h, w) -> (B, 3, s h, s w)``."""

    def __init__(self, scale: int) -> None:
        super().__init__()
        self.scale = scale
        self.body = UShaped(WIDTH)
        self.narrow = nn.Conv2d(WIDTH, FEATURES, 3, padding=1)
        self.last = nn.Conv2d(FEATURES, 3 * scale**2, 3, padding=1)

    def forward(self, x: Tensor) -> Tensor:
        return F.pixel_shuffle(self.last(self.narrow(self.body(x))), self.scale)


@final
class NSRD(Upsampler[History]):
    """A recurrent network that predicts the lighting.

    It reads lighting, depth and normal of the current and of the warped previous frames, and the previous output. The
    output is the lighting component, linear and unbounded, or without demodulation the radiance. Published widths and 2
    previous frames give 1,610,788 parameters at 4x4 and 145.37 G multiply-accumulates at 480x270 (supplement, table 2,
    which counts the gated convolution once per frame, and truncates digits).

    Where the paper does not say: previous positions outside the image read its border; the first frame of a clip stands
    in for those before it, without motion; there is no activation between the first convolutions and the ConvLSTM, nor
    between the last two; weights start as PyTorch's.

    Args:
        scale: ``s``; the paper has 2, 4 and 6.
        previous: number of previous frames that are warped, at least 1; the paper has 2.
        demodulate, motion_mask: stages.
        recur: called with the widths, returns the recurrent stage.
        locate, base: stages that the paper does not have: jitter, and a connection that bypasses the network.
    """

    extremes = (
        Gate("gate/gated 0", "NSRD: the gated convolution is shut.", bias_at(SHUT, lambda m: m.gated.gate_bias())),
        Gate("gate/gated 1", "NSRD: the gated convolution is open.", bias_at(OPEN, lambda m: m.gated.gate_bias())),
    )

    def __init__(
        self,
        scale: int,
        previous: int,
        demodulate: Demodulate,
        motion_mask: MotionMask,
        recur: MakeRecur,
        locate: Locate,
        base: Base,
    ) -> None:
        super().__init__()
        if previous < 1:
            raise UserError(f"Invalid model.previous={previous}: use at least 1 previous frame; the paper has 2.")
        self.scale, self.previous = check_scale(scale), previous
        self.demodulate, self.motion_mask = demodulate, motion_mask
        self.locate, self.base = locate, base
        inputs = INPUTS + locate.channels
        self.first = nn.Conv2d(inputs, FEATURES, 3, padding=1)
        self.gated = GatedConvolution(inputs + motion_mask.channels, FEATURES)
        self.recur = recur(channels=(1 + previous) * FEATURES, width=WIDTH, scale=self.scale)
        self.reconstruct = Reconstruction(self.scale)
        self.requires = demodulate.requires | motion_mask.requires | locate.requires | base.requires
        self.requires |= {"depth", "normal"}
        self.compares = demodulate.compares

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return self.demodulate.reference(clip)

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return self.demodulate.present(output, frame)

    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        return self.demodulate.radiance(output, frame)

    def warp_previous(self, inputs: tuple[Tensor, ...], vectors: tuple[Tensor, ...]) -> Tensor:
        """Return features of the warped previous frames, ``(B, 32 * previous, h, w)``, by shared weights (3.2)."""
        joined = torch.cat(vectors)
        features = self.gated(self.motion_mask(warp(torch.cat(inputs), joined[:, :2]), joined))
        return torch.cat(features.chunk(self.previous), dim=1)

    def forward(self, frame: Frame, state: History | None) -> tuple[Tensor, History]:
        depth, normal = frame.need("depth", "normal")
        # Lighting has at least float32; a network of weights in bfloat16 reads bfloat16.
        light = self.demodulate(frame).to(depth.dtype)
        current = self.locate.append(torch.cat((light, depth, normal), dim=1), frame)
        vectors = self.motion_mask.vectors(frame)
        if state is None:
            # The exporter merges tensors that are the same object while tracing, so the state holds copies.
            vectors = torch.zeros_like(vectors)
            inputs = tuple(current.clone() for _ in range(self.previous))
            state = History(inputs, tuple(vectors.clone() for _ in inputs[1:]), (), ())
        chained = chain(self.locate.between_samples(vectors, frame, state.located), state.vectors)
        shallow = torch.cat((self.first(current), self.warp_previous(state.inputs, chained)), dim=1)
        motion = self.locate.at_target(vectors[:, :2], frame, self.scale)
        features, memory = self.recur(shallow, motion, state.carried)
        # Convert to float32 first: half-precision sums lose small radiance.
        predicted = self.reconstruct(features).to(current.dtype)
        output = self.base(predicted, light, frame)
        carried = self.recur.carry(output, memory)
        return output, History((current, *state.inputs[:-1]), chained[:-1], carried, self.locate.remember(frame))
