"""Routes for cameras: walks along lines, and tripods."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.kit.shapes import Point
from supersampling.scenes.scene import Array, Route

Line = Sequence[Point] | NDArray[np.float64]


def walk(name: str, eyes: Line, focus: Line) -> Route:
    """Return a route along the line ``eyes`` that looks at the same share of the line ``focus``, metres."""
    return Route(name, np.array(eyes, np.float32), np.array(focus, np.float32))


def tripod(name: str, eye: Point, focus: Point, fov: float = 1.05) -> Route:
    """Return the route of a camera that stands at ``eye`` and looks at ``focus`` (metres).

    ``fov`` is vertical, in radians.
    """
    back = np.subtract(eye, focus)
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    pose = np.eye(4, dtype=np.float32)
    pose[:3] = np.stack([right, np.cross(back, right), back, eye], 1)

    def recorded(_: float) -> Array:
        return pose

    return Route(name, np.array([eye, eye], np.float32), None, recorded, fov)
