"""ENSS (Mercier et al. 2023, "Efficient neural supersampling on a novel gaming dataset")."""

import copy
from collections.abc import Callable
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.ops.resample import check_scale, jitter_aligned_upsample
from supersampling.stages.confine import Confine
from supersampling.stages.flow import Flow
from supersampling.stages.gate import OPEN, SHUT, Gate, bias_at
from supersampling.stages.history import History
from supersampling.stages.kernel_prediction import KernelPrediction, convolve
from supersampling.stages.motion_grid import MotionGrid
from supersampling.stages.reproject import Reproject

MakeKernels = Callable[[Tensor, Tensor], KernelPrediction]
GUIDES = 6  # colour, depth and the two components of the jitter
RANDOM_PART = 0.3


class Network(nn.Module):
    """The bottom of figure 4: ``(B, inputs, h, w) -> (B, outputs, h, w)``, all at low resolution, of any size.

    A convolution, ``depth`` more of ``features`` channels, each followed by a ReLU, and a last one without. The kernels
    of the first and of the last depend on the jitter; their biases are learned.

    The paper says that it builds on QuickSRNet (Berger et al. 2023), but does not state the initialisation: here it is
    that network's, except for the size of the random part. Identities are added to PyTorch's own kernels at 0.3 of
    their size, so that the first three inputs pass to the first three outputs at all positions of a block: training
    starts near nearest-neighbour upsampling of the colour. At full size, the random part hid the colour, and 250 short
    steps ended 0.8 dB lower.
    """

    def __init__(
        self, inputs: int, features: int, depth: int, block: int, planes: int, kernel_prediction: MakeKernels
    ) -> None:
        super().__init__()
        convs = [nn.Conv2d(inputs, features, 3, padding=1)]
        convs += [nn.Conv2d(features, features, 3, padding=1) for _ in range(depth)]
        last = nn.Conv2d(features, block * planes, 3, padding=1)
        with torch.no_grad():
            last.weight.mul_(RANDOM_PART)
            for conv in convs:
                conv.weight.mul_(RANDOM_PART)
                channels = range(min(conv.in_channels, features))
                conv.weight[channels, channels, 1, 1] += 1.0
            for c in range(min(3, features)):
                last.weight[c * block : (c + 1) * block, c, 1, 1] += 1.0
        first, *body = convs
        self.kernels = kernel_prediction(first.weight.detach(), last.weight.detach())
        assert first.bias is not None
        assert last.bias is not None
        self.first_bias, self.last_bias = first.bias, last.bias
        self.body = nn.ModuleList(body)

    def forward(self, x: Tensor, jitter: Tensor) -> Tensor:
        first, last = self.kernels(jitter)
        x = F.relu(convolve(x, first, self.first_bias))
        for conv in self.body:
            x = F.relu(conv(x))
        return convolve(x, last, self.last_bias)


@final
class ENSS(Upsampler[tuple[Tensor, ...]]):
    """A small network at low resolution, whose candidate is blended with the reprojected previous output.

    The state is the history ``(B, 4, H, W)``, colour and one recurrent feature, followed by what `flow` remembers. S is
    f16-m1, M f32-m3, L f64-m5 (section 5).

    Where the paper does not say: convolutions pad with zeros; the candidate is brought to [0, 1] by `confine`, as
    QuickSRNet clips; the recurrent feature's activation is a tanh (only the mask's is named); the jitter is also an
    input, as two constant planes in low-resolution pixels (eq 2); depth is the linear depth of the data, 0 at the near
    plane, as in the paper's; the history before the first frame is the jitter-aligned input, with features of 0;
    outside the previous image its border is repeated; depth-to-space orders channels as
    `torch.nn.functional.pixel_shuffle`: colour, mask, feature.

    Args:
        scale: ``s``.
        features: ``f``, channels of the inner layers.
        depth: ``m``, number of layers between the first and the last.
        flow, motion_grid, reproject, history, confine: stages.
        kernel_prediction: called with the initial kernels of the first and of the last convolution, returns the stage.
    """

    over_time = frozenset({"mask"})  # figure 6
    extremes = (
        Gate("gate/mask 0", "ENSS: the candidate is not used.", bias_at(SHUT, lambda m: m.bias_of("mask"))),
        Gate("gate/mask 1", "ENSS: the previous output is not used.", bias_at(OPEN, lambda m: m.bias_of("mask"))),
        Gate(
            "gate/feature 1", "ENSS: the recurrent feature at its bound.", bias_at(OPEN, lambda m: m.bias_of("feature"))
        ),
    )

    def __init__(
        self,
        scale: int,
        features: int,
        depth: int,
        flow: Flow,
        motion_grid: MotionGrid,
        reproject: Reproject,
        history: History,
        confine: Confine,
        kernel_prediction: MakeKernels,
    ) -> None:
        super().__init__()
        if features < 1 or depth < 0:
            raise UserError(
                f"Invalid model.features={features} with model.depth={depth}: use at least 1 feature and a depth of at "
                "least 0; the paper's M has 32 and 3."
            )
        self.scale = check_scale(scale)
        self.flow, self.motion_grid, self.reproject = flow, motion_grid, reproject
        self.history, self.confine = history, confine
        inputs = GUIDES + history.carried * scale**2
        planes = 3 + len(history.extra)
        self.network = Network(inputs, features, depth, scale**2, planes, kernel_prediction)
        self.requires = frozenset({"color", "depth", "jitter"})
        if history.carried:
            self.requires |= flow.requires

    def forward(self, frame: Frame, state: tuple[Tensor, ...] | None) -> tuple[Tensor, tuple[Tensor, ...]]:
        output, carried = self.history(*self._predict(frame, state))
        if not self.history.carried:
            return output, ()
        return output, (carried, *self.flow.remember(frame))

    def step_images(self, frame: Frame, state: tuple[Tensor, ...] | None) -> dict[str, Tensor]:
        return self.history.images(*self._predict(frame, state))

    def _predict(self, frame: Frame, state: tuple[Tensor, ...] | None) -> tuple[Tensor, Tensor, Tensor | None]:
        """Return the candidate ``(B, 3, H, W)``, the other predicted planes, and the warped history (eq 2)."""
        color, depth, jitter = frame.need("color", "depth", "jitter")
        planes = jitter[..., None, None].expand(-1, -1, *color.shape[-2:])
        inputs = [color, depth, planes]
        previous = None
        if self.history.carried:
            previous = self._previous(frame, state)
            inputs.append(F.pixel_unshuffle(previous, self.scale))  # space-to-depth

        predicted = self.network(torch.cat(inputs, dim=1), jitter)  # eq 2
        # Blending and history stay in full precision under autocast: rounding errors would add up over frames.
        predicted = F.pixel_shuffle(predicted.to(color.dtype), self.scale)
        return self.confine(predicted[:, :3]), predicted[:, 3:], previous

    def _previous(self, frame: Frame, state: tuple[Tensor, ...] | None) -> Tensor:
        """Return the history warped to this frame, ``(B, carried, H, W)``: the warping module (section 4.1)."""
        color, depth, jitter = frame.need("color", "depth", "jitter")
        if state is None:
            return self.history.start(jitter_aligned_upsample(color, jitter, self.scale))
        carried, *memory = state
        motion = self.flow(frame, tuple(memory))
        if motion is not None:
            carried = self.reproject(carried, self.motion_grid(motion, depth, self.scale))
        # Values that are not finite would survive every blend.
        return torch.nan_to_num(carried, 0.0, 0.0, 0.0)

    def bias_of(self, plane: str) -> Tensor | None:
        """Return the last bias of a plane of `History.extra`, ``(scale**2,)``, or None if there is no such plane."""
        if plane not in self.history.extra:
            return None
        block, first = self.scale**2, 3 + self.history.extra.index(plane)
        return self.network.last_bias[first * block : (first + 1) * block]

    def with_precomputed_kernels(self, jitters: Tensor) -> "ENSS":
        """Return a copy for inference, with the kernels of a jitter sequence ``(N, 2)`` instead of the MLP (4.2)."""
        kernels = self.network.kernels
        return copy.deepcopy(self, {id(kernels): kernels.precompute(jitters)})
