"""Means over clips with bootstrap intervals; every comparison of two methods is paired over clips.

Clips are the unit of resampling: frames of one clip are far from independent.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RESAMPLES = 4000
SEED = 0
LEVEL = 0.95


@dataclass(frozen=True)
class Estimate:
    """A mean over ``clips`` clips and its interval at `LEVEL`; one clip has no interval (``low`` and ``high`` NaN)."""

    mean: float
    low: float
    high: float
    clips: int

    @property
    def half_width(self) -> float:
        return (self.high - self.low) / 2

    @property
    def resolved(self) -> bool:
        """Whether the interval excludes zero; without an interval nothing is resolved."""
        return self.low > 0 or self.high < 0


def bootstrap_mean(values: NDArray[np.float64]) -> Estimate:
    """Mean of ``values (n,)``, one number a clip, with the percentile bootstrap interval over clips.

    The resampling is seeded: the same values give the same interval. An infinite value (the PSNR of two equal
    images) makes the mean infinite and leaves no interval.
    """
    if values.ndim != 1 or values.size == 0:
        raise ValueError(f"values must be (n,) with n >= 1, got shape {values.shape}")
    mean = float(values.mean())
    if values.size == 1 or not np.isfinite(values).all():
        return Estimate(mean, float("nan"), float("nan"), values.size)
    chosen = np.random.default_rng(SEED).integers(0, values.size, size=(RESAMPLES, values.size))
    tail = 100 * (1 - LEVEL) / 2
    low, high = np.percentile(values[chosen].mean(axis=1), [tail, 100 - tail])
    return Estimate(mean, float(low), float(high), values.size)


def paired_difference(ours: NDArray[np.float64], theirs: NDArray[np.float64]) -> Estimate:
    """Mean of ``ours - theirs``, both ``(n,)`` over the same clips in the same order, with its bootstrap interval."""
    if ours.shape != theirs.shape:
        raise ValueError(
            f"a paired difference needs the same clips, got shapes {ours.shape} and {theirs.shape}"
        )
    return bootstrap_mean(ours - theirs)
