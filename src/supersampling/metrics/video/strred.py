"""ST-RRED: Soundararajan and Bovik 2013, "Video Quality Assessment by Reduced Reference Spatio-Temporal Entropic
Differencing".

The 3x3 blocks of one oriented band of a steerable pyramid are modelled as Gaussian vectors with a covariance ``K``
times a local variance ``s^2`` (a Gaussian scale mixture), observed through noise of variance 0.1. The entropy of each
block, weighted by its variance, is compared between output and reference: in the frame (spatial) and in the difference
to the next frame (temporal). 0 means no difference.

The conventions are those of scikit-video 1.1.11, whose numbers are in use: the full-reference case (blocks compared one
by one); pairs of frames (0, 1), (2, 3), ...; one band (scikit-video's 0, pyrtools' 3) of level 4 of the fifth-order
filters; the entropy without the paper's factor of one half, with a natural logarithm in its constant although the other
logarithms have base 2. Frames are luma in levels of 0 to 255. scikit-video rounds to float32 before a matrix inverse,
this module stays in float64: that is the only difference, up to 4e-5 of the values on rendered frames.
"""

import math
from functools import cache
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.video.base import Scoring, VideoMetric

BLOCK = 3
NOISE = 0.1
LEVEL = 4
BAND = 3
"""In pyrtools' order; scikit-video's number is 0."""

SMALLEST = 48
"""Pixels per side: six pixels of the band, so that there are more blocks than pixels in a block."""


@final
class StRred(VideoMetric):
    """``srred`` and ``trred``, the spatial and temporal index averaged over the clip's pairs, and their product
    ``strred``.

    Luma is that of BT.709, full range, not rounded. The last frame of an odd number has no partner and does not count.

    Raises `UserError` for frames with a side below 48 pixels.
    """

    better = {"strred": "lower", "srred": "lower", "trred": "lower"}

    def begin(self) -> Scoring:
        return _Pairs()


@final
class _Pairs(Scoring):
    def __init__(self) -> None:
        # (2, h, w): the bands of output and target for the first frame of a pair.
        self._first: Tensor | None = None
        self._spatial = self._temporal = 0.0
        self._pairs = 0

    def add(self, moment: Moment) -> None:
        bands = oriented_band(luma(torch.cat((moment.output, moment.target))))
        if self._first is None:
            self._first = bands
            return
        (s0, t0), (s1, t1) = (information(a, b) for a, b in zip(self._first, bands))
        self._spatial += (s0 - s1).abs().mean().item()
        self._temporal += (t0 - t1).abs().mean().item()
        self._pairs += 1
        self._first = None

    def finish(self) -> dict[str, float]:
        pairs = self._pairs or math.nan
        spatial, temporal = self._spatial / pairs, self._temporal / pairs
        return dict(zip(StRred.names, (spatial * temporal, spatial, temporal)))


def luma(image: Tensor) -> Tensor:
    """Return the BT.709 luma ``(B, H, W)`` in [0, 255] of an image ``(B, 3, H, W)`` in [0, 1]."""
    weights = image.new_tensor((0.2126, 0.7152, 0.0722))
    return 255.0 * (image * weights[:, None, None]).sum(dim=1)


def oriented_band(images: Tensor) -> Tensor:
    """Return band 3 of level 4 of the steerable pyramid with ``sp5`` filters (Karasaridis and Simoncelli 1996).

    Borders are reflected. ``(B, H, W) -> (B, ceil(H / 8), ceil(W / 8))``, float64 on the host.
    """
    height, width = images.shape[-2:]
    if min(height, width) < SMALLEST:
        raise UserError(
            f"Frames of {width}x{height} pixels are too small for ST-RRED: "
            f"use at least {SMALLEST}x{SMALLEST}, or leave it out."
        )
    first, low, band = (kernel.to(images) for kernel in _filters())
    level = _correlate(images[:, None], first)
    for _ in range(LEVEL - 1):
        level = _correlate(level, low, stride=2)
    return _correlate(level, band)[:, 0].cpu().double()


@cache
def _filters() -> tuple[Tensor, Tensor, Tensor]:
    try:
        from pyrtools.pyramids.filters import steerable_filters
    except ImportError as error:
        raise UserError("ST-RRED needs the package pyrtools: run pip install pyrtools.") from error
    kernels = steerable_filters("sp5_filters")
    side = math.isqrt(kernels["bfilts"].shape[0])
    band = kernels["bfilts"][:, BAND].reshape(side, side).T
    first, low, band = (torch.tensor(k)[None, None] for k in (kernels["lo0filt"], kernels["lofilt"], band))
    return first, low, band


def _correlate(images: Tensor, kernel: Tensor, stride: int = 1) -> Tensor:
    margin = kernel.shape[-1] // 2
    return F.conv2d(F.pad(images, (margin,) * 4, mode="reflect"), kernel, stride=stride)


def information(first: Tensor, second: Tensor) -> tuple[Tensor, Tensor]:
    """Return the weighted entropies ``(h // 3, w // 3)`` of the first band ``(h, w)`` and of the bands' difference."""
    variance, entropy = _entropies(first)
    change, change_entropy = _entropies(first - second)
    weight = (1.0 + variance).log2()
    return weight * entropy, weight * (1.0 + change).log2() * change_entropy


def _entropies(band: Tensor) -> tuple[Tensor, Tensor]:
    """Return each block's variance ``s^2 = x^T K^-1 x / N`` and entropy ``sum_k log2(s^2 lambda_k + noise) + log(2 pi
    e)``.

    ``K`` is the covariance of all blocks, including overlapping ones. Directions in which the band does not vary, where
    ``K`` has no inverse, are left out: a black frame has no direction left, and its entropies are 0.
    """
    rows, columns = band.shape[0] // BLOCK, band.shape[1] // BLOCK
    band = band[: rows * BLOCK, : columns * BLOCK][None, None]
    values, vectors = torch.linalg.eigh(torch.cov(F.unfold(band, BLOCK)[0], correction=0))
    varying = values > values.max().clamp_min(0.0) * 1e-12
    values, vectors = values[varying], vectors[:, varying]
    blocks = F.unfold(band, BLOCK, stride=BLOCK)[0]  # (9, blocks)
    variance = ((vectors.T @ blocks).square() / values[:, None]).sum(dim=0) / BLOCK**2
    entropy = (variance * values[:, None] + NOISE).log2().sum(dim=0) + len(values) * math.log(2.0 * math.pi * math.e)
    return variance.view(rows, columns), entropy.view(rows, columns)
