"""Image metrics, one value a frame. A name carries its convention: two conventions never share a name.

All take ``output`` and ``target (B, 3, H, W)`` in [0, 1] and return ``(B,)``.
"""

import torch
from torch import Tensor

from supersampling.errors import UserError
from supersampling.ops.window import gaussian_mean

PSNR_CAP = 100.0
"""dB; what identical images get, so that means stay finite."""

WINDOW = 11
SIGMA = 1.5


def psnr(output: Tensor, target: Tensor) -> Tensor:
    """Peak signal-to-noise ratio in dB for peak 1, over all RGB values of a frame; at most `PSNR_CAP`."""
    error = (output - target).square().mean(dim=(1, 2, 3))
    return -10.0 * error.clamp_min(10.0 ** (-PSNR_CAP / 10.0)).log10()


def ssim_gauss11(output: Tensor, target: Tensor) -> Tensor:
    """SSIM of Wang et al. 2004, as ``skimage.metrics.structural_similarity`` with ``gaussian_weights=True,
    sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=...`` computes it: mean over RGB and
    over whole windows.

    Raises `UserError` for images smaller than 11x11.
    """
    return _ssim(output, target, 0.01**2, 0.03**2)


def mssim_thesis(output: Tensor, target: Tensor) -> Tensor:
    """MSSIM with the constants of Swensen 2021, 4.3.5: ``C1 = 0.01^2``, ``C2 = 0.02^2``, ``C3 = C2 / 2``.

    ``C3 = C2 / 2`` merges contrast and structure, so that only ``C2`` differs from `ssim_gauss11`. The thesis
    gives a window of 11; that it is Gaussian with sigma 1.5, on RGB and whole windows only, is assumed here.
    """
    return _ssim(output, target, 0.01**2, 0.02**2)


def _ssim(output: Tensor, target: Tensor, c1: float, c2: float) -> Tensor:
    height, width = output.shape[-2:]
    if min(height, width) < WINDOW:
        raise UserError(
            f"SSIM needs images of at least {WINDOW}x{WINDOW} pixels, got {width}x{height}; use larger ones."
        )
    # Variances do not change under a shift, and squares of values around 0 lose fewer bits.
    x, y = output - 0.5, target - 0.5
    mean_x, mean_y, square, product = gaussian_mean(torch.stack((x, y, x * x + y * y, x * y)), WINDOW, SIGMA)
    variances = square - mean_x * mean_x - mean_y * mean_y
    covariance = product - mean_x * mean_y
    mean_x, mean_y = mean_x + 0.5, mean_y + 0.5
    luminance = (2.0 * mean_x * mean_y + c1) / (mean_x * mean_x + mean_y * mean_y + c1)
    return (luminance * (2.0 * covariance + c2) / (variances + c2)).mean(dim=(1, 2, 3))
