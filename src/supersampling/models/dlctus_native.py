"""DLCTUS on a processor, in eleven passes of C++ per frame (Swensen 2021, chapter 4)."""

import copy
from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.dlctus import DLCTUS, STRIDE, WIDTH
from supersampling.models.native import dlctus as native
from supersampling.models.native.library import load_library
from supersampling.ops.resample import BOUNDARY
from supersampling.stages.accumulate import AccumulationBuffer
from supersampling.stages.confine import Sigmoid
from supersampling.stages.pad import JitterAligned
from supersampling.stages.reproject import Bicubic9

SCALES = (1, 2, 4)  # a block holds whole low-resolution pixels


@final
class DLCTUSNative(Upsampler[Tensor]):
    """The published composition, with any dilation, in float32; equal to the plain form up to rounding.

    It runs one clip at a time, without gradients. Compared with PyTorch's operations it saves passes over the target
    resolution: the history is reprojected directly into the order that the first convolution reads; the jitter-aligned
    and the zero-upsampled input are never stored, and of the latter's weights only those that meet a sample are used;
    the residual blocks' convolutions are Winograd's, with bias, ReLU, sum and the repetition of borders fused in. The
    state ``(1, 4, H, W)`` and the output are channels-last in memory.

    A state that is not finite is dropped as a whole; the plain form drops only the pixels that are not finite.

    Args:
        model: the plain form, which is copied.

    Raises:
        UserError: the composition or the scale is not supported, or there is no C++ compiler.
    """

    def __init__(self, model: DLCTUS) -> None:
        super().__init__()
        published = {"reproject": Bicubic9, "pad": JitterAligned, "accumulate": AccumulationBuffer}
        for slot, stage in published.items():
            if not isinstance(getattr(model, slot), stage):
                raise UserError(
                    f"{type(getattr(model, slot)).__name__} in model/{slot} does not run on the native backend, which "
                    f"only has {stage.__name__}: use another backend."
                )
        if isinstance(model.confine, Sigmoid) or model.scale not in SCALES:
            raise UserError(
                f"The native backend only has DLCTUS with a clamp at scale 1, 2 or 4, not "
                f"{type(model.confine).__name__} at scale {model.scale}: use another backend."
            )
        load_library()
        assert isinstance(model.reproject, Bicubic9)
        self.scale, self.requires, self.a = model.scale, model.requires, model.reproject.a
        self.dilate = copy.deepcopy(model.dilate)
        down = model.network.down
        layers = [block[k] for block in model.network.blocks for k in (0, 2)]  # type: ignore[index]
        with torch.no_grad():
            self.weight = nn.Buffer(down.weight.permute(2, 3, 1, 0).float().cpu().contiguous())
            biases = [layer.bias for layer in (down, *layers)]
            self.bias = nn.Buffer(torch.stack(biases).float().cpu())
            self.points = nn.Buffer(torch.stack([native.transform_kernel(c.weight.float().cpu()) for c in layers]))
        self.eval()

    @torch.no_grad()
    def forward(self, frame: Frame, state: Tensor | None) -> tuple[Tensor, Tensor]:
        color, depth, motion, jitter = frame.need("color", "depth", "motion", "jitter")
        self._check(color, state)
        x_jitter, y_jitter = jitter[0].tolist()
        inputs = native.Inputs(
            color.contiguous(),
            depth.contiguous(),
            self.dilate(motion, depth).contiguous(),
            (x_jitter, y_jitter),
            self.scale,
            self.a,
        )
        if state is not None:
            # A history that is not finite somewhere is started again: the passes would keep such values.
            state = state.contiguous(memory_format=torch.channels_last) if state.sum().isfinite() else None
        blocks = native.prepare(inputs, state)
        x = native.linear(blocks, self._weights(jitter), self.bias[0])
        inner = torch.empty_like(x)
        for k in range(0, len(self.points), 2):
            native.convolve(x, self.points[k], self.bias[k + 1], None, inner)
            native.convolve(inner, self.points[k + 1], self.bias[k + 2], x, x)
        state = native.construct(inputs, blocks, x)
        return state[:, :3], state

    def _check(self, color: Tensor, state: Tensor | None) -> None:
        b, _, h, w = color.shape
        if b != 1 or color.dtype != torch.float32 or color.device.type != "cpu":
            raise UserError(
                f"The native backend takes one clip in float32 on the processor, not {b} in {color.dtype} on "
                f"{color.device}: use another backend."
            )
        if h * self.scale % STRIDE or w * self.scale % STRIDE:
            raise UserError(
                f"The native backend takes targets in multiples of {STRIDE}, not {w * self.scale}x{h * self.scale}: "
                "use another backend."
            )
        if state is not None and state.shape[-2:] != (h * self.scale, w * self.scale):
            raise UserError(
                f"The history is {state.shape[-1]}x{state.shape[-2]}, the target {w * self.scale}x{h * self.scale}: "
                "start a clip without a state after a change of size."
            )

    def _weights(self, jitter: Tensor) -> Tensor:
        """Return the first convolution ``(K, 32)``: the history's weights, and those of the positions with samples."""
        place = torch.floor((jitter[0] + 0.5) * self.scale + BOUNDARY).nan_to_num().clamp(0, self.scale - 1)
        column, row = place.int().tolist()
        history = self.weight[:, :, 4:].reshape(-1, WIDTH)
        samples = self.weight[row :: self.scale, column :: self.scale, :4].reshape(-1, WIDTH)
        return torch.cat((history, samples))
