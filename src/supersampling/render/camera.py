"""Cameras, and the window of a larger frame that a shot renders."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Camera:
    """Perspective pinhole camera. ``view`` is world-to-camera (4, 4), looking down -z, y up; ``fov`` is vertical, radians."""

    view: Matrix
    fov: float = 1.05


@dataclass(frozen=True)
class Window:
    """The part of a ``frame_width x frame_height`` frame that is rendered; all in target (high-resolution) pixels.

    ``x, y`` is its top-left corner. A whole frame is the window ``(0, 0, frame_width, frame_height)``. The vertical field of
    view spans the whole frame, so a window shows what that part of the whole frame would.
    """

    frame_width: int
    frame_height: int
    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Shot:
    """One instant to render, with the previous one that motion vectors refer to (itself on a clip's first frame)."""

    camera: Camera
    previous_camera: Camera
    seconds: float
    previous_seconds: float
    window: Window
