"""Route as a smooth line for a camera: eye and heading as functions of the distance travelled."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from supersampling.scenes.scene import Route, Vector

FRAMES_PER_SECOND = 60.0  # the thesis's aim (4.3.4) and QRISP's rate (annex A.2); NSRR and NSRD give none

_KNOTS = 513
_EYE_BLUR, _HEADING_BLUR = 0.02, 0.04  # standard deviations, as parts of the route's length


@dataclass(frozen=True, eq=False)
class Poses:
    """Camera poses of a clip: ``eye (T, 3)`` in metres, ``forward (T, 3)``, ``roll (T,)`` in radians.

    ``forward`` has any length and is never vertical; roll turns the camera clockwise about it.
    """

    eye: Vector
    forward: Vector
    roll: Vector


def route_length(points: Vector) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def along(points: Vector, distance: Vector) -> Vector:
    """Return positions at arc lengths ``distance`` of a polyline, with corners rounded by a short moving average."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(steps)))
    radius = 0.08 * arc[-1]
    offsets = np.linspace(-radius, radius, 9)
    nearby = np.clip(distance[:, None] + offsets, 0.0, arc[-1])
    return np.stack([np.interp(nearby, arc, points[:, k]).mean(axis=1) for k in range(3)], axis=1)


def heading(route: Route, points: Vector, distance: Vector, eye: Vector) -> Vector:
    """Return viewing directions towards the focus or, without one, along the route.

    They are vertical or zero where the route is vertical or has no length.
    """
    length = route_length(points)
    if route.focus is not None:
        focus = np.asarray(route.focus, dtype=np.float64)
        forward = along(focus, distance * (route_length(focus) / max(length, 1e-9))) - eye
    else:
        reach = 0.15 * length
        forward = along(points, np.minimum(distance + reach, length)) - along(points, np.maximum(distance - reach, 0.0))
    forward = forward / np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    forward[:, 1] = np.clip(forward[:, 1], -0.6, 0.6)
    return forward


def directions(yaw: Vector, pitch: Vector) -> Vector:
    """Return unit vectors ``(T, 3)``: yaw 0 looks along -z and grows to the right (+x), pitch grows up; radians."""
    return np.stack((np.sin(yaw) * np.cos(pitch), np.sin(pitch), -np.cos(yaw) * np.cos(pitch)), axis=1)


class Rail:
    """Line of a route whose eye and heading are smooth functions of the distance.

    A camera that stops on it is exactly still, and a moving one never jerks. On a route without length all poses are
    equal. ``aimless`` routes (without a focus or a level stretch) have no heading; their yaw is 0.
    """

    def __init__(self, route: Route) -> None:
        points = np.asarray(route.points, dtype=np.float64)
        self.length = route_length(points)
        part = np.linspace(0.0, 1.0, _KNOTS)
        eye = along(points, part * self.length)
        forward = heading(route, points, part * self.length, eye)
        level = np.hypot(forward[:, 0], forward[:, 2])
        aimed = level > 0.05
        self.aimless = not bool(aimed.any())
        yaw = np.zeros(_KNOTS)
        if not self.aimless:
            # A camera straight above or below its focus has no yaw: interpolate from the yaw before to the yaw after.
            known = np.unwrap(np.arctan2(forward[aimed, 0], -forward[aimed, 2]))
            yaw = np.interp(part, part[aimed], known)
        # 0.8 limits a steep heading to 37 degrees.
        pitch = np.arctan2(forward[:, 1], np.maximum(level, 0.8))
        self._eye = CubicSpline(part, gaussian_filter1d(eye, _EYE_BLUR * _KNOTS, axis=0, mode="nearest"))
        heads = np.stack((yaw, pitch), axis=1)
        self._head = CubicSpline(part, gaussian_filter1d(heads, _HEADING_BLUR * _KNOTS, axis=0, mode="nearest"))

    @classmethod
    def sample(cls, route: Route, rng: np.random.Generator) -> "Rail":
        """Return the rail of a route; half of the time it is reversed if the route has no focus."""
        if rng.random() < 0.5 and route.focus is None:
            return cls(replace(route, points=np.asarray(route.points)[::-1]))
        return cls(route)

    def poses(self, distance: Vector) -> tuple[Vector, Vector, Vector]:
        """Return eyes ``(T, 3)``, yaws and pitches ``(T,)`` at distances ``(T,)`` in metres, clamped to the ends."""
        part = np.clip(distance / max(self.length, 1e-9), 0.0, 1.0)
        head = self._head(part)
        return self._eye(part), head[:, 0], head[:, 1]

    def ride(self, rng: np.random.Generator, speed: float, travelled: Vector) -> Vector:
        """Return distances from a random start after ``travelled`` frames ``(T,)`` at ``speed`` m/s.

        The speed is lower where the rail is too short for it.
        """
        way = np.minimum(speed * float(travelled[-1]) / FRAMES_PER_SECOND, self.length)
        return rng.uniform(0.0, self.length - way) + way * travelled / max(float(travelled[-1]), 1e-9)
