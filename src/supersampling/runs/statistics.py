"""Means and paired differences over scenes, clips and seeds, with bootstrap intervals.

What an interval speaks about: *other scenes like these, filmed as these were* and, where a method has several seeds,
*another training of it*. Two clips of a scene share its content and are not independent, so whole scenes are
resampled with all of their clips. How clips differ within a scene is already in how far the means of scenes scatter; to
resample clips within them as well would count it twice. Clips of one scene alone speak about other clips of that scene.

Seeds are crossed with scenes (every seed is scored on every clip), so they are resampled on their own, for either
method on its own: the same number as a seed of two methods gives them nothing in common. With one seed an interval
speaks about these weights, not about another training.

A percentile bootstrap of few units is too narrow: resampling shrinks the spread by ``(n-1)/n`` and knows nothing of
Student's t. Here it gives the interval its shape; its width is stretched, about the mean, to twice Student's t times
the standard error, the degrees of freedom after Satterthwaite (the expanded percentile interval of Hesterberg, "What
teachers should know about the bootstrap", The American Statistician 69(4), 2015, which moves the percentiles instead:
of four scenes or two seeds there are too few resamples for that).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import stdtrit

RESAMPLES = 4000
SEED = 0
LEVEL = 0.95
ROUNDING = 1e-12  # of the largest value
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A mean over ``clips`` clips of ``scenes`` scenes and its interval at `LEVEL`, NaN where there is none."""

    mean: float
    low: float
    high: float
    clips: int
    scenes: int = 1

    @property
    def half_width(self) -> float:
        return (self.high - self.low) / 2

    @property
    def resolved(self) -> bool:
        """Whether the interval excludes zero; without an interval nothing is resolved."""
        return self.low > 0 or self.high < 0


def bootstrap_mean(values: ArrayLike, scenes: ArrayLike | None = None) -> Estimate:
    """Return the mean of ``values (seeds, clips)`` or ``(clips,)`` with its interval; clips and seeds weigh the same.

    ``scenes (clips,)`` names each clip's scene; without it the clips are of one scene. One clip has no interval, nor
    have values of which one is infinite (the PSNR of two equal images). Resampling is seeded: the same values give
    the same interval.
    """
    return _estimate([np.atleast_2d(np.asarray(values, dtype=np.float64))], scenes)


def paired_difference(first: ArrayLike, second: ArrayLike, scenes: ArrayLike | None = None) -> Estimate:
    """Return the mean of ``first - second``, ``(seeds, clips)`` or ``(clips,)`` over the same clips in the same order.

    The numbers of seeds may differ. See `bootstrap_mean` for the rest.
    """
    a, b = (np.atleast_2d(np.asarray(values, dtype=np.float64)) for values in (first, second))
    if a.shape[1:] != b.shape[1:]:
        raise ValueError(f"paired differences need the same clips, got shapes {a.shape[1:]} and {b.shape[1:]}")
    return _estimate([a, -b], scenes)


def _estimate(parts: list[Array], scenes: ArrayLike | None) -> Estimate:
    """Return the mean of a sum of ``parts``, each ``(seeds, clips)``, whose seeds are independent of each other's."""
    clips = parts[0].shape[1]
    if any(part.ndim != 2 or part.size == 0 for part in parts):
        raise ValueError(f"values must hold a seed and a clip, got shapes {[part.shape for part in parts]}")
    names = np.zeros(clips) if scenes is None else np.asarray(scenes)
    if names.shape != (clips,):
        raise ValueError(f"scenes must name each of the {clips} clips, got shape {names.shape}")
    of_scene = np.unique(names, return_inverse=True)[1]
    count = int(of_scene.max()) + 1
    unit = of_scene if count > 1 else np.arange(clips)
    with np.errstate(invalid="ignore"):  # infinity less infinity
        mean = float(sum(part.mean() for part in parts))
    if unit.max() == 0 or not all(np.isfinite(part).all() for part in parts):
        return Estimate(mean, float("nan"), float("nan"), clips, count)
    if abs(mean) <= ROUNDING * max(float(np.abs(part).max()) for part in parts):
        mean = 0.0  # equal values whose sums were rounded differently
    units = np.eye(unit.max() + 1)[unit]
    low, high = _interval([part @ units for part in parts], units.sum(axis=0), mean)
    return Estimate(mean, low, high, clips, count)


def _interval(sums: list[Array], sizes: Array, mean: float) -> tuple[float, float]:
    """From the sums over each unit's clips, a ``(seeds, units)`` for each part, and the units' numbers of clips
    ``(units,)``."""
    units = len(sizes)
    error, freedom = _standard_error(sums, sizes, mean)
    if error == 0:
        return mean, mean
    rng = np.random.default_rng(SEED)
    drawn = rng.multinomial(units, np.full(units, 1 / units), RESAMPLES).astype(np.float64)
    clips = drawn @ sizes
    means = np.zeros(RESAMPLES)
    for part in sums:
        seeds = len(part)
        weights = rng.multinomial(seeds, np.full(seeds, 1 / seeds), RESAMPLES) / seeds
        means += (weights * (drawn @ part.T)).sum(axis=1) / clips
    tail = (1 - LEVEL) / 2
    ends = np.quantile(means, [tail, 1 - tail]) - mean
    width = 2 * stdtrit(freedom, 1 - tail) * error
    low, high = mean + width * ends / np.ptp(ends)
    return float(low), float(high)


def _standard_error(sums: list[Array], sizes: Array, mean: float) -> tuple[float, float]:
    """Standard error of the mean and its degrees of freedom (Satterthwaite).

    Units of unequal size enter as in a ratio estimate. How seeds and scenes interact is counted on both sides, which
    errs on the safe one.
    """
    units, clips = len(sizes), sizes.sum()
    deviations = sum(part.mean(axis=0) for part in sums) - mean * sizes
    terms = [(units / (units - 1) * float(np.sum(deviations**2)) / clips**2, units - 1)]
    for part in sums:
        seeds = len(part)
        if seeds > 1:
            terms.append((float(np.var(part.sum(axis=1) / clips, ddof=1)) / seeds, seeds - 1))
    variance = sum(value for value, _ in terms)
    spread = sum(value**2 / freedom for value, freedom in terms)
    # Rounding leaves a variance of about 1e-32 where all differences are the same.
    size = max(float(np.abs(part / sizes).max()) for part in sums)
    if np.sqrt(variance) <= ROUNDING * size:
        return 0.0, float(units - 1)
    return float(np.sqrt(variance)), variance**2 / spread
