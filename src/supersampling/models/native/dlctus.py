"""DLCTUS's passes over a frame (Swensen 2021, 4.1), float32 on a CPU, without gradients.

Symbols: ``h w`` low, ``H W = s h, s w`` target resolution, both multiples of 4; ``K = 64 + 4 (4 / s)^2`` values of a
4x4 block: its history by position and channel, followed by its samples.
"""

import ctypes
from dataclasses import dataclass

import torch
from torch import Tensor

from supersampling.models.native.library import load_library
from supersampling.ops.resample import pixel_centres

SIDE, WIDTH = 4, 32
_POINTER = ctypes.c_void_p

# Kernel transform, 6x3, of Winograd's F(4x4, 3x3) with points 0, 1, -1, 2, -2 (Lavin and Gray 2016).
_POINTS = (
    (1 / 4, 0.0, 0.0),
    (-1 / 6, -1 / 6, -1 / 6),
    (-1 / 6, 1 / 6, -1 / 6),
    (1 / 24, 1 / 12, 1 / 6),
    (1 / 24, -1 / 12, 1 / 6),
    (0.0, 0.0, 1.0),
)


class _Frame(ctypes.Structure):
    _fields_ = (
        *((name, _POINTER) for name in ("color", "depth", "motion", "centre_x", "centre_y")),
        *((name, ctypes.c_int) for name in ("height", "width", "scale")),
        *((name, ctypes.c_float) for name in ("jitter_x", "jitter_y", "a")),
    )


@dataclass(frozen=True)
class Inputs:
    """Inputs of `prepare` and `construct`, contiguous float32.

    ``color (1, 3, h, w)``, ``depth (1, 1, h, w)``, ``motion (1, 2, h, w)``; ``jitter`` is in low-resolution pixels,
    ``a`` the cubic kernel's parameter.
    """

    color: Tensor
    depth: Tensor
    motion: Tensor
    jitter: tuple[float, float]
    scale: int
    a: float

    def __post_init__(self) -> None:
        h, w = self.color.shape[-2:]
        for channels, tensor in ((3, self.color), (1, self.depth), (2, self.motion)):
            assert tensor.shape == (1, channels, h, w)
            assert tensor.is_contiguous()
            assert tensor.dtype == torch.float32

    @property
    def target(self) -> tuple[int, int]:
        """Return ``(H, W)``."""
        h, w = self.color.shape[-2:]
        return h * self.scale, w * self.scale

    @property
    def blocks(self) -> tuple[int, int, int]:
        """Return ``(H / 4, W / 4, K)``."""
        height, width = self.target
        return height // SIDE, width // SIDE, 4 * SIDE**2 + 4 * (SIDE // self.scale) ** 2


def prepare(inputs: Inputs, state: Tensor | None) -> Tensor:
    """Return the network's input ``(H / 4, W / 4, K)``: the state, reprojected and padded, and the samples.

    The state is ``(1, 4, H, W)``, channels last in memory, or None for the first frame.
    """
    if state is not None:
        assert state.shape == (1, 4, *inputs.target)
        assert state.dtype == torch.float32
        assert state.is_contiguous(memory_format=torch.channels_last)
    blocks = _empty(inputs.color, *inputs.blocks)
    load_library().ss_prepare(_frame(inputs), _pointer(state), _pointer(blocks), torch.get_num_threads())
    return blocks


def construct(inputs: Inputs, blocks: Tensor, x: Tensor) -> Tensor:
    """Return the new state ``(1, 4, H, W)``, channels last in memory, from the network's output ``(H/4, W/4, 32)``."""
    height, width = inputs.target
    state = _empty(inputs.color, 1, height, width, 4)
    threads = torch.get_num_threads()
    load_library().ss_construct(_frame(inputs), _pointer(blocks), _pointer(x), _pointer(state), threads)
    return state.permute(0, 3, 1, 2)


def linear(blocks: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    """Multiply ``blocks (..., K)`` by ``weight (K, 32)`` and add ``bias (32,)``: ``(..., 32)``."""
    x = blocks.new_empty(*blocks.shape[:-1], WIDTH)
    count, k = x.numel() // WIDTH, blocks.shape[-1]
    arguments = map(_pointer, (blocks, weight, bias, x))
    load_library().ss_linear(*arguments, count, k, torch.get_num_threads())
    return x


def transform_kernel(weight: Tensor) -> Tensor:
    """Transform a kernel ``(32, 32, 3, 3)`` for `convolve`: ``(36, 32, 32)`` by point, input and output."""
    g = torch.tensor(_POINTS, dtype=torch.float64, device=weight.device)
    points = torch.einsum("pi,oxij,qj->pqxo", g, weight.double(), g)
    return points.flatten(0, 1).to(weight.dtype).contiguous()


def convolve(x: Tensor, points: Tensor, bias: Tensor, residual: Tensor | None, out: Tensor) -> Tensor:
    """Write to ``out`` the 3x3 convolution of ``x (h, w, 32)``, borders repeated; return ``out``.

    Adds ``residual``, or applies ReLU if it is None. ``out`` may be ``residual``, never ``x``.
    """
    height, width, _ = x.shape
    arguments = map(_pointer, (x, points, bias, residual, out))
    load_library().ss_convolve(*arguments, height, width, torch.get_num_threads())
    return out


def _empty(like: Tensor, *shape: int) -> Tensor:
    tensor = like.new_empty(shape)
    load_library().ss_large_pages(_pointer(tensor), ctypes.c_size_t(tensor.numel()))
    return tensor


def _pointer(tensor: Tensor | None) -> ctypes.c_void_p:
    return _POINTER(None if tensor is None else tensor.data_ptr())


def _frame(inputs: Inputs) -> object:
    """Return a reference to the C structure, which keeps the tensors that it points to alive."""
    height, width = inputs.target
    centres = pixel_centres(width, inputs.color), pixel_centres(height, inputs.color)
    frame = _Frame(
        *(t.data_ptr() for t in (inputs.color, inputs.depth, inputs.motion, *centres)),
        *inputs.color.shape[-2:],
        inputs.scale,
        *inputs.jitter,
        inputs.a,
    )
    frame.centres = centres
    return ctypes.byref(frame)
