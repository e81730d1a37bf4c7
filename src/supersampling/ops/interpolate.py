"""Interpolation at arbitrary positions.

Symbols: ``f`` fraction in [0, 1) between two pixel centres, ``a`` the free parameter of the cubic convolution kernel
(Keys 1981), ``grid`` normalised ``grid_sample`` positions.
"""

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError
from supersampling.ops.cubic_gradient import bicubic_grid_sample

# The value of ``a`` in PyTorch's ``grid_sample`` and ``interpolate``.
TORCH_CUBIC = -0.75


def check_cubic(a: float) -> float:
    """Return ``a``; raise `UserError` outside [-1, 0], where the kernel is not a useful interpolator."""
    if not -1.0 <= a <= 0.0:
        raise UserError(
            f"Invalid a={a} of the cubic kernel: use a number between -1 and 0, e.g. -0.75 (PyTorch) or -0.5 "
            "(Catmull-Rom)."
        )
    return float(a)


def sample_bilinear(image: Tensor, grid: Tensor) -> Tensor:
    """Interpolate ``(B, C, H, W)`` bilinearly at ``grid (B, H', W', 2)``, borders repeated."""
    return F.grid_sample(image, grid, mode="bilinear", padding_mode="border", align_corners=False)


def sample_bicubic9(image: Tensor, grid: Tensor, a: float) -> Tensor:
    """Interpolate by cubic convolution with parameter ``a``, borders repeated; shapes as in `sample_bilinear`.

    Uses ``grid_sample`` for its built-in ``a = -0.75``, otherwise nine bilinear fetches (Swensen 2021, A.2).
    """
    if a == TORCH_CUBIC:
        return bicubic_grid_sample(image, grid)
    (x0, x12, x3), (wx0, wx12, wx3) = _cubic_taps(grid[..., 0], image.shape[-1], a)
    (y0, y12, y3), (wy0, wy12, wy3) = _cubic_taps(grid[..., 1], image.shape[-2], a)
    rows = ((y0, wy0), (y12, wy12), (y3, wy3))
    columns = ((x0, wx0), (x12, wx12), (x3, wx3))
    fetches = [
        sample_bilinear(image, torch.stack((x, y), dim=-1)) * (wx * wy).unsqueeze(1)
        for y, wy in rows
        for x, wx in columns
    ]
    return torch.stack(fetches).sum(0)


def sample_bicubic5(image: Tensor, grid: Tensor, a: float) -> Tensor:
    """Interpolate by cubic convolution without its four corner fetches, normalised again; Swensen 2021, 5.5.1.

    The sum of the remaining weights is ``1 - a^2 f_x (1 - f_x) f_y (1 - f_y)``, at least 0.93 for ``a`` in [-1, 0].
    Shapes as in `sample_bilinear`.
    """
    (x0, x12, x3), (wx0, wx12, wx3) = _cubic_taps(grid[..., 0], image.shape[-1], a)
    (y0, y12, y3), (wy0, wy12, wy3) = _cubic_taps(grid[..., 1], image.shape[-2], a)
    cross = (
        (x12, y0, wx12 * wy0),
        (x0, y12, wx0 * wy12),
        (x12, y12, wx12 * wy12),
        (x3, y12, wx3 * wy12),
        (x12, y3, wx12 * wy3),
    )
    fetches = [sample_bilinear(image, torch.stack((x, y), dim=-1)) * weight.unsqueeze(1) for x, y, weight in cross]
    total = torch.stack([weight for _, _, weight in cross]).sum(0)
    return torch.stack(fetches).sum(0) / total.unsqueeze(1)


def _cubic_taps(position: Tensor, size: int, a: float) -> tuple[tuple[Tensor, ...], tuple[Tensor, ...]]:
    """Return positions and weights of one axis's three fetches: first tap, the middle two combined, last tap."""
    pixel = (position + 1.0) * (0.5 * size) - 0.5
    base = pixel.floor()
    f = pixel - base
    w0 = a * f * (1.0 - f) ** 2
    w3 = a * f**2 * (1.0 - f)
    w2 = 1.0 - w0 - w3 - (((a + 2.0) * f - (a + 3.0)) * f * f + 1.0)
    # At least 1 for a <= 0, so the division below is safe.
    w12 = 1.0 - w0 - w3
    pixels = (base - 1.0, base + w2 / w12, base + 2.0)
    return tuple((2.0 * pixel + 1.0) / size - 1.0 for pixel in pixels), (w0, w12, w3)
