"""Image metrics, one value per frame. A name includes its convention: two conventions never share a name.

All take ``output`` and ``target (B, 3, H, W)`` in [0, 1] and return ``(B,)``. They do not change values: see
`supersampling.metrics.prepare` for values out of range, NaN and infinities. Without it, NaN gives NaN.
"""

import math

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError
from supersampling.ops.window import gaussian_mean

PSNR_CAP = 100.0
"""dB; the value of identical images, so that means stay finite."""

WINDOW = 11
SIGMA = 1.5
C1, C2 = 0.01**2, 0.03**2
STRIP = 128  # rows


def psnr(output: Tensor, target: Tensor) -> Tensor:
    """Return the peak signal-to-noise ratio in dB for peak 1, over all RGB values of a frame; at most `PSNR_CAP`."""
    error = (output - target).square().mean(dim=(1, 2, 3))
    return -10.0 * error.clamp_min(10.0 ** (-PSNR_CAP / 10.0)).log10()


def ssim_gauss11(output: Tensor, target: Tensor) -> Tensor:
    """Return the SSIM of Wang et al. 2004: mean over RGB and over whole windows.

    It equals ``skimage.metrics.structural_similarity`` with ``gaussian_weights=True, sigma=1.5,
    use_sample_covariance=False, data_range=1, channel_axis=...``. Raises `UserError` for images smaller than 11x11.
    """
    return _ssim(output, target)


def ssim_uniform11(output: Tensor, target: Tensor) -> Tensor:
    """Return SSIM as NSRD's published code computes it: mean over RGB and over whole windows.

    It equals ``skimage.metrics.structural_similarity`` with ``win_size=11, data_range=1, channel_axis=...``, that is a
    uniform window of 11 and the sample covariance (``n / (n - 1)``). NSRD's code truncates images to 8 bits, whereas
    `supersampling.metrics.prepare.EightBit` rounds. Raises `UserError` for images smaller than 11x11.
    """
    return _ssim(output, target, sigma=math.inf, unbiased=WINDOW**2 / (WINDOW**2 - 1))


def ssim_zero_pad11(output: Tensor, target: Tensor) -> Tensor:
    """Return SSIM as the published program of Swensen 2021 computes it: mean over RGB and over a window at each pixel.

    As `ssim_gauss11`, but images are zero outside, so that windows at the border count, and an image may be smaller
    than a window. Section 4.3.5 states a window of 11 and ``C3 = C2 / 2``, which merges contrast and structure; its
    ``C2 = 0.02^2`` is a misprint: the program (``_ssim`` of Network/metrics.py) has ``0.03^2`` in all its versions, and
    its result files average to the numbers of tables 2 and 16.
    """
    margin = (WINDOW // 2,) * 4
    return _ssim(F.pad(output, margin), F.pad(target, margin))


def _ssim(output: Tensor, target: Tensor, sigma: float = SIGMA, unbiased: float = 1.0) -> Tensor:
    """Return SSIM ``(B,)``; ``sigma`` is infinite for a uniform window, ``unbiased`` multiplies the (co)variances."""
    height, width = output.shape[-2:]
    if min(height, width) < WINDOW:
        raise UserError(f"Images of {width}x{height} pixels are too small for SSIM: use at least {WINDOW}x{WINDOW}.")
    rows, total = height - WINDOW + 1, output.new_zeros(len(output), dtype=torch.float64)
    # Strips of one channel stay in the cache: twice as fast at 1080p on a CPU.
    for x, y in zip(output.split(1, dim=1), target.split(1, dim=1)):
        for first in range(0, rows, STRIP):
            strip = slice(first, min(first + STRIP, rows) + WINDOW - 1)
            values = _ssim_map(x[:, 0, strip], y[:, 0, strip], sigma, unbiased)
            total += values.sum(dim=(1, 2), dtype=torch.float64)
    return (total / (output.shape[1] * rows * (width - WINDOW + 1))).to(output.dtype)


def _ssim_map(x: Tensor, y: Tensor, sigma: float, unbiased: float) -> Tensor:
    """Return the SSIM of every whole window of images ``(B, H, W)``."""
    # A shift does not change variances, and squares of values around 0 lose fewer bits.
    x, y = x - 0.5, y - 0.5
    moments = torch.stack((x, y, (x * x).addcmul_(y, y), x * y))
    mean_x, mean_y, square, product = gaussian_mean(moments, WINDOW, sigma)
    # In this order equal images get exactly 1: numerator and denominator round alike.
    variances = square.sub_((mean_x * mean_x).addcmul_(mean_y, mean_y)).mul_(unbiased)
    covariance = product.sub_(mean_x * mean_y).mul_(unbiased)
    mean_x, mean_y = mean_x.add_(0.5), mean_y.add_(0.5)
    luminance = (mean_x * mean_y).mul_(2.0).add_(C1)
    luminance /= mean_x.square_().addcmul_(mean_y, mean_y).add_(C1)
    return luminance.mul_(covariance.mul_(2.0).add_(C2)).div_(variances.add_(C2))
