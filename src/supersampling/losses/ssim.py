"""Structural dissimilarity as a loss."""

from collections.abc import Mapping
from typing import final

import torch
from torch import Tensor

from supersampling.errors import UserError
from supersampling.losses.base import Loss
from supersampling.metrics.image import SIGMA, WINDOW
from supersampling.ops.window import gaussian_mean


@final
class SSIM(Loss):
    """``1 - SSIM`` (Xiao et al. 2020, eq 1; Li et al. 2024, eq 6), in [0, 2].

    Windows and means are those of `metrics.image.ssim_gauss11`. The two factors of SSIM are computed as their distance
    from 1, so that the loss is exact to rounding near 0 and bounded for values of any size: with the error
    ``d = x - y``, ``1 - luminance = mean(d)^2 / (mean(x)^2 + mean(y)^2 + C1)`` and
    ``1 - contrast structure = var(d) / (var(x) + var(y) + C2)``.

    Args:
        data_range: ``L`` in ``C1 = (0.01 L)^2`` and ``C2 = (0.03 L)^2``, positive, in the method's domain. NSRD
            computes the SSIM of unbounded lighting without stating ``L``: 1 there too, about a white surface under its
            scene's exposure, so that much darker values count less.
    """

    requires = frozenset[str]()
    previous = 0

    def __init__(self, data_range: float) -> None:
        super().__init__()
        if not 0.0 < data_range < float("inf"):
            raise UserError(
                f"Invalid data_range={data_range} of SSIM: use a positive number, e.g. 1 for display colours."
            )
        self.c1, self.c2 = (0.01 * data_range) ** 2, (0.03 * data_range) ** 2

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        height, width = outputs.shape[-2:]
        if min(height, width) < WINDOW:
            raise UserError(
                f"Crops of {width}x{height} pixels are too small for SSIM: set budget.crop to at least {WINDOW}."
            )
        dtype = torch.promote_types(torch.promote_types(outputs.dtype, targets.dtype), torch.float32)
        x, y = outputs.to(dtype), targets.to(dtype)
        error = x - y
        # Variances are invariant to a shift, and squares of values around 0 lose fewer bits.
        centre = y.detach().mean(dim=(-2, -1), keepdim=True)
        x, y = x - centre, y - centre
        stacked = torch.stack((x, error, x * x + y * y, error * error))
        mean_x, mean_error, squares, squared_error = gaussian_mean(stacked, WINDOW, SIGMA)
        mean_y = mean_x - mean_error
        # Rounding may make the variance of a flat window negative; in exact arithmetic, var(d) <= 2 (var(x) + var(y)).
        error_variance = (squared_error - mean_error * mean_error).clamp_min(0.0)
        variances = torch.maximum(squares - mean_x * mean_x - mean_y * mean_y, 0.5 * error_variance)
        mean_x, mean_y = mean_x + centre, mean_y + centre
        luminance = mean_error * mean_error / (mean_x * mean_x + mean_y * mean_y + self.c1)
        structure = error_variance / (variances + self.c2)
        return (luminance + structure - luminance * structure).mean()
