"""PyTorch's bicubic ``grid_sample`` with a faster gradient on a CPU.

The interpolation is a sparse matrix with 16 weights per row; its gradient is a product with the transpose. PyTorch
scatters the same 16 values per pixel and channel one by one, which on one thread took 30% of a DLCTUS training step
(``scripts/timing/gradient.py`` compares the two). ``W H`` are the image's sides, ``N`` the number of positions.
"""

from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from scipy.sparse import csr_array
from torch import Tensor
from torch.autograd.function import once_differentiable

# The kernel's parameter, fixed in grid_sample.
_A = -0.75


def bicubic_grid_sample(image: Tensor, grid: Tensor) -> Tensor:
    """Interpolate by cubic convolution with ``a = -0.75``, borders repeated: bit-identical to ``grid_sample``.

    Args:
        image: ``(B, C, H, W)``.
        grid: ``(B, H', W', 2)`` normalised positions.

    Returns:
        ``(B, C, H', W')``.
    """
    only_image = image.requires_grad and not grid.requires_grad and image.device.type == "cpu"
    if only_image and image.dtype == torch.float32 and torch.is_grad_enabled():
        result: Tensor = _TransposedProduct.apply(image, grid)
        return result
    return _grid_sample(image, grid)


def _grid_sample(image: Tensor, grid: Tensor) -> Tensor:
    return F.grid_sample(image, grid, mode="bicubic", padding_mode="border", align_corners=False)


class _TransposedProduct(torch.autograd.Function):
    """``grid_sample`` whose gradient is a product with the transposed sparse matrix."""

    @staticmethod
    def forward(ctx: Any, image: Tensor, grid: Tensor) -> Tensor:
        ctx.save_for_backward(grid)
        ctx.size = image.shape[-2:]
        return _grid_sample(image, grid)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *grads: Tensor) -> tuple[Tensor, None]:
        (grid,) = ctx.saved_tensors
        (grad,) = grads
        b, c = grad.shape[:2]
        height, width = ctx.size
        columns, weights = _matrix(grid, height, width)
        starts = np.arange(0, columns[0].size + 1, 16, dtype=np.int32)
        rows = grad.reshape(b, c, -1).transpose(1, 2).contiguous().numpy()
        images = [
            csr_array((w.ravel(), k.ravel(), starts), shape=(len(k), height * width)).T @ row
            for w, k, row in zip(weights, columns, rows)
        ]
        return torch.from_numpy(np.stack(images)).transpose(1, 2).reshape(b, c, height, width), None


def _matrix(grid: Tensor, height: int, width: int) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return the flat indices ``(B, N, 16)`` of the pixels that each position reads, and their weights."""
    x, weight_x = _taps(grid[..., 0].flatten(), width)
    y, weight_y = _taps(grid[..., 1].flatten(), height)
    columns = np.repeat((y * width).numpy(), 4, axis=1) + np.tile(x.numpy(), (1, 4))
    # The outer product of two rows of four, as products with 0 and 1, is much faster than broadcasting.
    ones = torch.eye(4)
    weights = (weight_y @ ones.repeat_interleave(4, 1)) * (weight_x @ ones.repeat(1, 4))
    return columns.reshape(len(grid), -1, 16), weights.numpy().reshape(len(grid), -1, 16)


def _taps(position: Tensor, size: int) -> tuple[Tensor, Tensor]:
    """Return the four taps of one axis ``(N, 4)``: pixel indices, clamped to the image, and weights."""
    pixel = ((position + 1.0) * size - 1.0) * 0.5
    base = pixel.floor()
    f = pixel - base
    g = 1.0 - f
    inner = (((_A + 2.0) * t - (_A + 3.0)) * t * t + 1.0 for t in (f, g))
    weights = torch.stack((_A * f * g * g, *inner, _A * f * f * g), dim=-1)
    # Clamp before the conversion, which would overflow for distant positions.
    first = base.nan_to_num().clamp(-3, size + 2).int()
    taps = first.unsqueeze(-1) + torch.arange(-1, 3, dtype=torch.int32)
    return taps.clamp_(0, size - 1), weights
