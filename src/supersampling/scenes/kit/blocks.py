"""Fast `box`, `beam`, `quad` and `panel` of `shapes`, without subdivision, for scenes with thousands of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.shapes import ALL, Floats, Shape

# Directions to the right and down on each face, as seen from outside.
_RIGHT = {
    "front": (1, 0, 0),
    "back": (-1, 0, 0),
    "right": (0, 0, -1),
    "left": (0, 0, 1),
    "top": (1, 0, 0),
    "bottom": (1, 0, 0),
}
_DOWN = {
    "front": (0, -1, 0),
    "back": (0, -1, 0),
    "right": (0, -1, 0),
    "left": (0, -1, 0),
    "top": (0, 0, 1),
    "bottom": (0, 0, -1),
}
_RIGHTS = np.array([_RIGHT[f] for f in ALL], float)
_DOWNS = np.array([_DOWN[f] for f in ALL], float)
_NORMALS = np.cross(_RIGHTS, -_DOWNS)
_U = np.array([0.0, 1.0, 0.0, 1.0])  # corners of a face: top left, top right, bottom left, bottom right
_V = np.array([0.0, 0.0, 1.0, 1.0])
_CORNERS = 0.5 * (
    _NORMALS[:, None] + (2 * _U - 1)[:, None] * _RIGHTS[:, None] + (2 * _V - 1)[:, None] * _DOWNS[:, None]
)
_FIT = np.stack([_U, _V], 1)
_TRIANGLES = np.array([[0, 2, 3], [0, 3, 1]])
_INDEX = {face: k for k, face in enumerate(ALL)}


def box(size: ArrayLike, centre: ArrayLike = (0, 0, 0), faces: Sequence[str] = ALL, fit: bool = False) -> Shape:
    """Return the same as `shapes.box`."""
    indices = [_INDEX[f] for f in faces]
    count = len(indices)
    points = _CORNERS[indices] * np.asarray(size, float) + np.asarray(centre, float)
    if fit:
        uv = np.tile(_FIT, (count, 1))
    else:
        axes = np.stack([_RIGHTS[indices], _DOWNS[indices]], -1)
        uv = (points @ axes).reshape(-1, 2)
    triangles = (_TRIANGLES[None] + 4 * np.arange(count)[:, None, None]).reshape(-1, 3)
    return Shape(points.reshape(-1, 3), _NORMALS[indices].repeat(4, axis=0), uv, triangles)


def beam(a: ArrayLike, b: ArrayLike, width: float, height: float | None = None) -> Shape:
    """Return the same as `shapes.beam`."""
    start, end = np.asarray(a, float), np.asarray(b, float)
    length = float(np.linalg.norm(end - start))
    up = (end - start) / length
    helper = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = _cross(up, helper)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, up, _cross(x, up), start
    return box((width, length, height or width), (0, length / 2, 0)).transform(matrix)


def quad(corner: ArrayLike, right: ArrayLike, down: ArrayLike) -> Shape:
    """Return the same as `shapes.quad`, of one cell."""
    start, x, y = (np.asarray(v, float) for v in (corner, right, down))
    normal = _cross(y, x)
    normal /= np.linalg.norm(normal)
    points = np.stack([start, start + x, start + y, start + x + y])
    return Shape(points, np.tile(normal, (4, 1)), _FIT, _TRIANGLES)


def panel(corner: ArrayLike, right: ArrayLike, down: ArrayLike) -> Shape:
    """Return the same as `shapes.panel`, of one cell."""
    x, y = np.asarray(right, float), np.asarray(down, float)
    flat = quad(corner, x, y)
    axes = np.stack([x / np.linalg.norm(x), y / np.linalg.norm(y)], 1)
    return Shape(flat.positions, flat.normals, flat.positions @ axes, flat.triangles)


def _cross(a: Floats, b: Floats) -> Floats:
    """Return the cross product of two vectors, ten times as fast as NumPy's."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
