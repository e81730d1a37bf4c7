"""The scales of a clip's pictures: one exposure, one depth range and one length of motion for all of them."""

import math
from dataclasses import dataclass

import numpy as np

from supersampling.show.clip import Array, ClipView

_LIGHT = ("radiance", "target_radiance", "emission", "high_emission")
_MOTION = ("motion", "high_motion", "motion_dual")
_TOLERATED = 3  # stops: exposed radiance is shown unchanged, unless it would be near black or white
_LEAST_MOTION = 0.1  # low-resolution pixels; with less, the wheel would show rounding errors
_LEAST_ERROR = 4.0 / 255.0


@dataclass(frozen=True)
class Scales:
    """Exposure in ``stops``, ``nearest`` and ``farthest`` depth of surfaces, and ``motion`` at full colour in
    low-resolution pixels."""

    stops: int
    nearest: float
    farthest: float
    motion: float

    @classmethod
    def measure(cls, clip: ClipView, frame: int) -> "Scales":
        """Measure exposure and depth in one frame, and motion in the whole clip, so that its frames can be compared."""
        light = clip.find(frame, *_LIGHT)
        depth = clip.find(frame, "depth", "high_depth")
        nearest, farthest = depth_range(clip.read(depth, frame)) if depth else (0.0, 1.0)
        stops = exposure(clip.read(light, frame)) if light else 0
        return cls(
            stops=stops if abs(stops) > _TOLERATED else 0,
            nearest=nearest,
            farthest=farthest,
            motion=_motion_scale(clip, frame),
        )


def exposure(light: Array) -> int:
    """Return the integer stops that bring the 95th percentile of a linear image ``(3, h, w)`` nearest to 1; 0 if
    black."""
    bright = float(np.nanpercentile(np.where(np.isfinite(light), light, np.nan).max(axis=0), 95.0))
    return -round(math.log2(bright)) if bright > 0.0 else 0


def depth_range(depth: Array) -> tuple[float, float]:
    """Return the smallest and the largest depth of surfaces; (0, 1) if the image shows only sky."""
    surfaces = depth[np.isfinite(depth) & (depth < 1.0)]
    return (float(surfaces.min()), float(surfaces.max())) if surfaces.size else (0.0, 1.0)


def error_scale(error: Array) -> float:
    """Return the 99.5th percentile of an error, at least 4/255."""
    return max(float(np.percentile(error, 99.5)), _LEAST_ERROR)


def in_pixels(clip: ClipView, motion: Array) -> Array:
    """Return motion ``(2, ...)`` in low-resolution pixels instead of units of the image."""
    return motion * np.array(clip.low_size, dtype=np.float32)[:, None, None]


def _motion_scale(clip: ClipView, frame: int) -> float:
    """Return the 99.5th percentile of the clip's motion, rounded up to two digits."""
    name = clip.find(frame, *_MOTION)
    if name is None:
        return _LEAST_MOTION
    lengths = []
    for t in range(clip.frames):
        if clip.has(name, t):
            lengths.append(np.hypot(*in_pixels(clip, clip.read(name, t))).ravel())
    values = np.concatenate(lengths)
    values = values[np.isfinite(values)]
    longest = max(float(np.percentile(values, 99.5)) if values.size else 0.0, _LEAST_MOTION)
    step = 10.0 ** (math.floor(math.log10(longest)) - 1)
    return round(math.ceil(longest / step - 1e-9) * step, 12)
