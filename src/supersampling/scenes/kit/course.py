"""Travel along a closed curve at an even speed, banked in the bends."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from supersampling.scenes.kit.shapes import Floats
from supersampling.scenes.scene import Array, Transform

GRAVITY = 9.81


class Course:
    """Smooth closed curve through ``points (N, 3)``, parametrised by arc length; ``length`` in metres."""

    def __init__(self, points: ArrayLike) -> None:
        curve = _closed(np.asarray(points, float), None)
        for _ in range(3):  # equal steps along the curve, so that its parameter is the arc length
            dense = curve(np.linspace(0, float(curve.x[-1]), 2049))
            arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
            even = np.linspace(0, arc[-1], 129)[:-1]
            curve = _closed(np.stack([np.interp(even, arc, dense[:, k]) for k in range(3)], 1), float(arc[-1]))
        self._curve, self.length = curve, float(curve.x[-1])

    def ride(self, speed: float, start: float, bank: float = 0.0) -> Transform:
        """Return a ride at ``speed`` (m/s; negative runs against the curve) with the nose (+x) along the way.

        ``start`` is a share of a lap. ``bank`` is the steepest bank in radians; 0 keeps wheels on the ground.
        """
        sense = float(np.sign(speed))

        @lru_cache(maxsize=1024)  # all parts of a vehicle ask for the same moments
        def pose(seconds: float) -> Array:
            distance = (start * self.length + speed * seconds) % self.length
            matrix = np.eye(4)
            forward = sense * self._curve(distance, 1)
            forward /= np.linalg.norm(forward)
            right = np.cross(forward, (0.0, 1.0, 0.0))
            right /= np.linalg.norm(right)
            up = np.cross(right, forward)
            if bank:
                pull = speed**2 * float(self._curve(distance, 2) @ right) / GRAVITY
                roll = bank * np.tanh(pull / 3.0)
                right, up = np.cos(roll) * right - np.sin(roll) * up, np.cos(roll) * up + np.sin(roll) * right
            matrix[:3, :3] = np.stack([forward, up, right], 1)
            matrix[:3, 3] = self._curve(distance)
            return matrix.astype(np.float32)

        return pose


def _closed(points: Floats, length: float | None) -> CubicSpline:
    step = np.arange(len(points) + 1) * ((length or float(len(points))) / len(points))
    return CubicSpline(step, np.concatenate([points, points[:1]]), bc_type="periodic")
