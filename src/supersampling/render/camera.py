"""Cameras, and the window of a larger frame that a shot renders."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Camera:
    """Perspective camera: ``view (4, 4)`` is world-to-camera, along -z with y up; ``fov`` is vertical, in radians."""

    view: Matrix
    fov: float = 1.05


@dataclass(frozen=True)
class Window:
    """Rendered part of a ``frame_width x frame_height`` frame; all values are in target (high-resolution) pixels.

    ``x, y`` is its top-left corner. A whole frame is the window ``(0, 0, frame_width, frame_height)``. The vertical
    field of view spans the whole frame, so a window shows the same as that part of a whole frame.
    """

    frame_width: int
    frame_height: int
    x: int
    y: int
    width: int
    height: int

    def grown(self, margin: int) -> "Window":
        """Return the window that is ``margin`` pixels larger on each side."""
        width, height = self.width + 2 * margin, self.height + 2 * margin
        return replace(self, x=self.x - margin, y=self.y - margin, width=width, height=height)


@dataclass(frozen=True, eq=False)
class Shot:
    """One instant to render and the previous instant that motion vectors refer to.

    On a clip's first frame both are the same instant.
    """

    camera: Camera
    previous_camera: Camera
    seconds: float
    previous_seconds: float
    window: Window
