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
    """``1 - SSIM`` (Xiao et al. 2020, eq 1; Li et al. 2024, eq 6), in [0, 2]; the windows and the means of
    `metrics.image.ssim_gauss11`.

    Written as the share that is lost, so that it is exact to rounding near 0 and bounded for values of any size: with the
    error ``d = x - y``, ``1 - luminance = mean(d)^2 / (mean(x)^2 + mean(y)^2 + C1)`` and
    ``1 - contrast structure = var(d) / (var(x) + var(y) + C2)``.

    Args:
        data_range: ``L`` in ``C1 = (0.01 L)^2`` and ``C2 = (0.03 L)^2``, above 0, in the method's domain. NSRD takes the SSIM
            of unbounded lighting and does not say with which: 1 there too, about a white surface under its scene's
            exposure, so that what is much darker counts less.
    """

    requires = frozenset[str]()
    previous = 0

    def __init__(self, data_range: float) -> None:
        super().__init__()
        if not 0.0 < data_range < float("inf"):
            raise UserError(f"data_range of SSIM must be above 0, got {data_range}; 1 is that of display colours.")
        self.c1, self.c2 = (0.01 * data_range) ** 2, (0.03 * data_range) ** 2

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        height, width = outputs.shape[-2:]
        if min(height, width) < WINDOW:
            raise UserError(
                f"SSIM needs crops of at least {WINDOW}x{WINDOW} pixels, got {width}x{height}: raise budget.crop."
            )
        dtype = torch.promote_types(torch.promote_types(outputs.dtype, targets.dtype), torch.float32)
        x, y = outputs.to(dtype), targets.to(dtype)
        error = x - y
        # Variances do not change under a shift, and squares of values around 0 lose fewer bits.
        centre = y.detach().mean(dim=(-2, -1), keepdim=True)
        x, y = x - centre, y - centre
        stacked = torch.stack((x, error, x * x + y * y, error * error))
        mean_x, mean_error, squares, squared_error = gaussian_mean(stacked, WINDOW, SIGMA)
        mean_y = mean_x - mean_error
        # Rounding may leave less than nothing of a flat window's variance; exactly, var(d) <= 2 (var(x) + var(y)).
        lost = (squared_error - mean_error * mean_error).clamp_min(0.0)
        variances = torch.maximum(squares - mean_x * mean_x - mean_y * mean_y, 0.5 * lost)
        mean_x, mean_y = mean_x + centre, mean_y + centre
        luminance = mean_error * mean_error / (mean_x * mean_x + mean_y * mean_y + self.c1)
        structure = lost / (variances + self.c2)
        return (luminance + structure - luminance * structure).mean()
