"""DLCTUS's passes over a frame (Swensen 2021, 4.1), float32 on a processor, without gradients.

Symbols: ``h w`` low, ``H W = s h, s w`` target resolution, both sides of it multiples of 4; ``K = 64 + 4 (4 / s)^2`` values of a
4x4 block: its history by place and channel, then its samples.
"""

import ctypes
from dataclasses import dataclass

import torch
from torch import Tensor

from supersampling.models.native.library import library
from supersampling.ops.resample import pixel_centres

SIDE, WIDTH = 4, 32
_ANY = ctypes.c_void_p

# Winograd's F(4x4, 3x3), points 0, 1, -1, 2, -2 (Lavin and Gray 2016): a kernel's transform, 6x3.
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
        *((name, _ANY) for name in ("color", "depth", "motion", "centre_x", "centre_y")),
        *((name, ctypes.c_int) for name in ("height", "width", "scale")),
        *((name, ctypes.c_float) for name in ("jitter_x", "jitter_y", "a")),
    )


@dataclass(frozen=True)
class Inputs:
    """What both ends of the frame read: ``color (1, 3, h, w)``, ``depth (1, 1, h, w)``, ``motion (1, 2, h, w)``, contiguous.

    ``jitter`` is in low-resolution pixels, ``a`` the cubic kernel's parameter.
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
        """``(H, W)``."""
        h, w = self.color.shape[-2:]
        return h * self.scale, w * self.scale

    @property
    def blocks(self) -> tuple[int, int, int]:
        """``(H / 4, W / 4, K)``."""
        height, width = self.target
        return height // SIDE, width // SIDE, 4 * SIDE**2 + 4 * (SIDE // self.scale) ** 2


def prepare(inputs: Inputs, state: Tensor | None) -> Tensor:
    """``(H / 4, W / 4, K)``: the state ``(1, 4, H, W)``, channels last in memory, reprojected and padded; and samples."""
    if state is not None:
        assert state.shape == (1, 4, *inputs.target)
        assert state.dtype == torch.float32
        assert state.is_contiguous(memory_format=torch.channels_last)
    blocks = _new(inputs.color, *inputs.blocks)
    library().ss_prepare(_frame(inputs), _at(state), _at(blocks), torch.get_num_threads())
    return blocks


def construct(inputs: Inputs, blocks: Tensor, x: Tensor) -> Tensor:
    """The new state ``(1, 4, H, W)``, channels last in memory, by the network's output ``(H / 4, W / 4, 32)``."""
    height, width = inputs.target
    state = _new(inputs.color, 1, height, width, 4)
    library().ss_construct(_frame(inputs), _at(blocks), _at(x), _at(state), torch.get_num_threads())
    return state.permute(0, 3, 1, 2)


def linear(blocks: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    """``(..., K)`` times ``weight (K, 32)`` plus ``bias (32,)``: ``(..., 32)``."""
    x = blocks.new_empty(*blocks.shape[:-1], WIDTH)
    count, k = x.numel() // WIDTH, blocks.shape[-1]
    library().ss_linear(_at(blocks), _at(weight), _at(bias), _at(x), count, k, torch.get_num_threads())
    return x


def transformed(weight: Tensor) -> Tensor:
    """A kernel ``(32, 32, 3, 3)`` as `convolve` takes it, ``(36, 32, 32)``: place, input, output."""
    g = torch.tensor(_POINTS, dtype=torch.float64, device=weight.device)
    points = torch.einsum("pi,oxij,qj->pqxo", g, weight.double(), g)
    return points.flatten(0, 1).to(weight.dtype).contiguous()


def convolve(x: Tensor, points: Tensor, bias: Tensor, added: Tensor | None, out: Tensor) -> Tensor:
    """3x3 convolution of ``x (h, w, 32)``, borders repeated, into ``out``; plus ``added``, or without one its ReLU.

    ``out`` may be ``added``, never ``x``.
    """
    height, width, _ = x.shape
    library().ss_convolve(_at(x), _at(points), _at(bias), _at(added), _at(out), height, width, torch.get_num_threads())
    return out


def _new(like: Tensor, *shape: int) -> Tensor:
    tensor = like.new_empty(shape)
    library().ss_large_pages(_at(tensor), ctypes.c_size_t(tensor.numel()))
    return tensor


def _at(tensor: Tensor | None) -> ctypes.c_void_p:
    return _ANY(None if tensor is None else tensor.data_ptr())


def _frame(inputs: Inputs) -> object:
    """The structure by reference, which keeps what it points to."""
    height, width = inputs.target
    centres = pixel_centres(width, inputs.color), pixel_centres(height, inputs.color)
    frame = _Frame(
        *(t.data_ptr() for t in (inputs.color, inputs.depth, inputs.motion, *centres)),
        *inputs.color.shape[-2:],
        inputs.scale,
        *inputs.jitter,
        inputs.a,
    )
    frame.kept = centres
    return ctypes.byref(frame)
