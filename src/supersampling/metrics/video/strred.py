"""ST-RRED: Soundararajan and Bovik 2013, "Video Quality Assessment by Reduced Reference Spatio-Temporal Entropic Differencing".

One oriented band of a steerable pyramid, cut into 3x3 blocks, is modelled as Gaussian vectors of covariance ``K`` times a
local variance ``s^2`` (a Gaussian scale mixture), seen through noise of variance 0.1. Each block's entropy, weighted by its
variance, is compared between output and reference: in the frame (spatial) and in the difference to the next one (temporal).
0 is no difference; lower is better.

Conventions, those of scikit-video 1.1.11, whose numbers are in use: the full-reference case (blocks compared one by one);
pairs of frames (0, 1), (2, 3), ...; one band (scikit-video's 0, pyrtools' 3) of level 4 of the fifth-order filters; the entropy
without the paper's factor of one half, its constant a natural logarithm though the rest has base 2. Frames are luma in levels
of 0 to 255. Where scikit-video rounds to float32 on the way to an inverse, this stays in float64: that is all that their numbers
differ by, up to 4e-5 of them on rendered frames.
"""

import math
from functools import cache
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError
from supersampling.metrics.suite import Moment
from supersampling.metrics.video.base import Scoring, VideoMetric

BLOCK = 3
NOISE = 0.1
LEVEL = 4
BAND = 3
"""In pyrtools' order; scikit-video calls it 0."""

SMALLEST = 48
"""Pixels a side: six band pixels, so that there are more blocks than a block has pixels."""


@final
class StRred(VideoMetric):
    """``srred`` and ``trred``, the spatial and temporal index averaged over the clip's pairs, and their product ``strred``.

    Luma is BT.709's, full range, not rounded. An odd last frame has no pair and does not count.

    Raises `UserError` for frames with a side below 48 pixels.
    """

    names = ("strred", "srred", "trred")
    requires = frozenset({"target"})

    def begin(self) -> Scoring:
        return _Pairs()


@final
class _Pairs(Scoring):
    def __init__(self) -> None:
        self._first: Tensor | None = None  # (2, h, w): the bands of output and target, of a pair's first frame
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
    """BT.709 luma ``(B, H, W)`` in [0, 255] of ``(B, 3, H, W)`` in [0, 1]."""
    weights = image.new_tensor((0.2126, 0.7152, 0.0722))
    return 255.0 * (image * weights[:, None, None]).sum(dim=1)


def oriented_band(images: Tensor) -> Tensor:
    """Band 3 of level 4 of the steerable pyramid with ``sp5`` filters (Karasaridis and Simoncelli 1996), borders reflected:
    ``(B, H, W) -> (B, ceil(H / 8), ceil(W / 8))``, float64 on the host."""
    height, width = images.shape[-2:]
    if min(height, width) < SMALLEST:
        raise UserError(
            f"ST-RRED needs frames of at least {SMALLEST}x{SMALLEST} pixels, got {width}x{height}; "
            "use larger ones or leave it out."
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
        raise UserError("ST-RRED needs the package pyrtools: pip install pyrtools.") from error
    kernels = steerable_filters("sp5_filters")
    side = math.isqrt(kernels["bfilts"].shape[0])
    band = kernels["bfilts"][:, BAND].reshape(side, side).T
    first, low, band = (torch.tensor(k)[None, None] for k in (kernels["lo0filt"], kernels["lofilt"], band))
    return first, low, band


def _correlate(images: Tensor, kernel: Tensor, stride: int = 1) -> Tensor:
    margin = kernel.shape[-1] // 2
    return F.conv2d(F.pad(images, (margin,) * 4, mode="reflect"), kernel, stride=stride)


def information(first: Tensor, second: Tensor) -> tuple[Tensor, Tensor]:
    """Weighted entropies ``(h // 3, w // 3)`` of a pair of bands ``(h, w)``: of the first, and of their difference."""
    variance, entropy = _entropies(first)
    change, change_entropy = _entropies(first - second)
    weight = (1.0 + variance).log2()
    return weight * entropy, weight * (1.0 + change).log2() * change_entropy


def _entropies(band: Tensor) -> tuple[Tensor, Tensor]:
    """Each block's local variance ``s^2 = x^T K^-1 x / N`` and entropy ``sum_k log2(s^2 lambda_k + noise) + log(2 pi e)``.

    ``K`` is the covariance of all blocks, overlapping ones too. Directions in which the band does not vary, where ``K`` has no
    inverse, are left out: none is left of a black frame, whose entropies are 0.
    """
    rows, columns = band.shape[0] // BLOCK, band.shape[1] // BLOCK
    band = band[: rows * BLOCK, : columns * BLOCK][None, None]
    values, vectors = torch.linalg.eigh(torch.cov(F.unfold(band, BLOCK)[0], correction=0))
    kept = values > values.max().clamp_min(0.0) * 1e-12
    values, vectors = values[kept], vectors[:, kept]
    blocks = F.unfold(band, BLOCK, stride=BLOCK)[0]  # (9, blocks)
    variance = ((vectors.T @ blocks).square() / values[:, None]).sum(dim=0) / BLOCK**2
    entropy = (variance * values[:, None] + NOISE).log2().sum(dim=0) + len(values) * math.log(2.0 * math.pi * math.e)
    return variance.view(rows, columns), entropy.view(rows, columns)
