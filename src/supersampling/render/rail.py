"""A route as a smooth line that a camera rides: eye and heading by the distance travelled."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from supersampling.scenes.scene import Route, Vector

FRAMES_PER_SECOND = 60.0  # what the thesis aims at (4.3.4), and QRISP's (annex A.2); NSRR and NSRD give none

_KNOTS = 513
_EYE_BLUR, _HEADING_BLUR = 0.02, 0.04  # standard deviations, parts of the route's length


@dataclass(frozen=True, eq=False)
class Poses:
    """A clip's camera: ``eye (T, 3)`` metres, ``forward (T, 3)`` any length, never vertical, ``roll (T,)`` radians.

    Roll turns the camera clockwise about its viewing direction.
    """

    eye: Vector
    forward: Vector
    roll: Vector


def route_length(points: Vector) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def along(points: Vector, distance: Vector) -> Vector:
    """Positions at arc lengths ``distance`` of a polyline, its corners rounded by averaging over a short stretch."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(steps)))
    radius = 0.08 * arc[-1]
    offsets = np.linspace(-radius, radius, 9)
    at = np.clip(distance[:, None] + offsets, 0.0, arc[-1])
    return np.stack([np.interp(at, arc, points[:, k]).mean(axis=1) for k in range(3)], axis=1)


def heading(route: Route, points: Vector, distance: Vector, eye: Vector) -> Vector:
    """Viewing directions towards the focus, else along the route; vertical or zero where the route gives no other."""
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
    """Unit vectors ``(T, 3)``: yaw 0 looks along -z and grows to the right (+x), pitch grows upwards; radians."""
    return np.stack((np.sin(yaw) * np.cos(pitch), np.sin(pitch), -np.cos(yaw) * np.cos(pitch)), axis=1)


class Rail:
    """A route's line with eye and heading smooth in the distance: who stops on it is still, who rides on it never jerks.

    A route without length stands; ``aimless`` ones (no focus, no level stretch) have no heading of their own and get 0.
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
            # Straight above or below its focus a camera has no yaw: it turns evenly from the one before to the one after.
            known = np.unwrap(np.arctan2(forward[aimed, 0], -forward[aimed, 2]))
            yaw = np.interp(part, part[aimed], known)
        pitch = np.arctan2(forward[:, 1], np.maximum(level, 0.8))  # 0.8: a steep heading is no steeper than 37 degrees
        self._eye = CubicSpline(part, gaussian_filter1d(eye, _EYE_BLUR * _KNOTS, axis=0, mode="nearest"))
        heads = np.stack((yaw, pitch), axis=1)
        self._head = CubicSpline(part, gaussian_filter1d(heads, _HEADING_BLUR * _KNOTS, axis=0, mode="nearest"))

    @classmethod
    def of(cls, route: Route, rng: np.random.Generator) -> "Rail":
        """The route's rail, half of the time the other way round where no focus says how to look."""
        if rng.random() < 0.5 and route.focus is None:
            return cls(replace(route, points=np.asarray(route.points)[::-1]))
        return cls(route)

    def at(self, distance: Vector) -> tuple[Vector, Vector, Vector]:
        """Eyes ``(T, 3)``, yaws and pitches ``(T,)`` at distances ``(T,)`` in metres from the start, held at the ends."""
        part = np.clip(distance / max(self.length, 1e-9), 0.0, 1.0)
        head = self._head(part)
        return self._eye(part), head[:, 0], head[:, 1]

    def ride(self, rng: np.random.Generator, speed: float, travelled: Vector) -> Vector:
        """Distances from a random start for ``travelled`` frames ``(T,)`` at ``speed`` m/s, or as fast as the rail is long."""
        way = np.minimum(speed * float(travelled[-1]) / FRAMES_PER_SECOND, self.length)
        return rng.uniform(0.0, self.length - way) + way * travelled / max(float(travelled[-1]), 1e-9)
