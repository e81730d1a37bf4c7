"""The gain of a reprojection on a wave, computed from its kernel only: an independent truth for the measured roll-outs.

Symbols: ``f`` fraction of a pixel, ``w`` angular frequency in radians per pixel, ``a`` the cubic kernel's
parameter (Keys 1981).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def cubic_weights(a: float, f: Array) -> Array:
    """Return the cubic weights of the pixels at -1, 0, 1, 2, ``(4, ...)``."""
    g = 1.0 - f
    inner = [((a + 2.0) * t - (a + 3.0)) * t * t + 1.0 for t in (f, g)]
    return np.stack((a * f * g * g, *inner, a * f * f * g))


def linear_weights(f: Array) -> Array:
    """Return the linear weights of the pixels at -1, 0, 1, 2, ``(4, ...)``."""
    return np.stack((np.zeros_like(f), 1.0 - f, f, np.zeros_like(f)))


def waves(w: Array) -> Complex:
    """Return a wave's values at -1, 0, 1, 2, ``(4, ...)``."""
    return np.stack([np.exp(1j * k * w) for k in (-1, 0, 1, 2)])


@dataclass(frozen=True)
class Kernel:
    """A reprojection stage: ``taps`` 2 (bilinear), 5 or 9, and ``a``."""

    name: str
    taps: int
    a: float = 0.0

    def response(self, fx: Array, fy: Array, wx: Array, wy: Array) -> Array:
        """Return the magnitude of a wave of magnitude 1 after one reprojection; arguments broadcast."""
        axes = []
        corners = []
        for f, w in ((fx, wx), (fy, wy)):
            weights = linear_weights(f) if self.taps == 2 else cubic_weights(self.a, f)
            terms = [weight * wave for weight, wave in zip(weights, waves(w))]
            axes.append(sum(terms))
            corners.append((terms[0] + terms[3], weights[0] + weights[3]))
        value = axes[0] * axes[1]
        if self.taps == 5:  # without the corners, renormalised
            (cx, sx), (cy, sy) = corners
            value = (value - cx * cy) / (1.0 - sx * sy)
        return np.abs(value)

    def gain(self, fx: float, fy: float, frequencies: int = 241) -> float:
        """Return the largest response at one fraction of a pixel."""
        fraction = np.array(fx), np.array(fy)
        centre, reach, count = (0.0, 0.0), math.pi, frequencies
        best = 0.0
        for _ in range(5):  # each time around the best frequencies so far
            x, y = (np.linspace(c - reach, c + reach, count) for c in centre)
            values = self.response(*fraction, x[:, None], y)
            i, j = np.unravel_index(values.argmax(), values.shape)
            best, centre, reach, count = float(values[i, j]), (x[i], y[j]), 2.0 * reach / count, 21
        return best

    def worst(self, fractions: int = 25) -> tuple[float, float, float]:
        """Return ``(gain, fx, fy)`` of the largest gain over all fractions of a pixel."""
        f = np.linspace(0.0, 1.0, fractions)
        coarse = [(self.gain(x, y, 61), x, y) for x in f for y in f if y <= x <= 0.5]
        return max(coarse)


def cubic_gain(a: float) -> float:
    """Return the largest gain of cubic convolution on two axes, in closed form; it occurs at half a pixel.

    There the response of one axis is ``(1 - a) c + a c**3`` with ``c = cos(w / 2)``: 1 at ``c = 1``, and largest at
    ``c**2 = (1 - a) / (-3 a)``, which some wave satisfies if ``a < -1/2``. For ``a >= -1/2`` no wave is amplified.
    """
    if a >= -0.5:
        return 1.0
    return ((2.0 / 3.0) * (1.0 - a) * math.sqrt((1.0 - a) / (-3.0 * a))) ** 2
