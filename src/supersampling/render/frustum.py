"""Culling of axis-aligned boxes against view volumes and spheres."""

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Matrix

Boxes = tuple[NDArray[np.float64], NDArray[np.float64]]


def clip_planes(view_projection: Matrix) -> Matrix:
    """Return the six planes ``(6, 4)`` of a clip space; a point is inside if ``plane @ (x, y, z, 1) >= 0`` for all."""
    rows = view_projection
    return np.stack([rows[3] + sign * rows[axis] for axis in range(3) for sign in (1.0, -1.0)])


def visible(boxes: Boxes, planes: Matrix) -> NDArray[np.bool_]:
    """Return ``(N,)``: false only if an axis-aligned box ``(lo (N, 3), hi (N, 3))`` lies wholly outside a plane."""
    lo, hi = boxes
    centre, half = (lo + hi) / 2.0, (hi - lo) / 2.0
    distance = centre @ planes[:, :3].T + planes[:, 3]
    reach = half @ np.abs(planes[:, :3]).T
    return np.asarray((distance + reach >= 0.0).all(axis=1))


def transformed(lo: NDArray[np.float64], hi: NDArray[np.float64], matrices: NDArray[np.float64]) -> Boxes:
    """Return the world boxes of local boxes ``(N, 3)`` under affine ``(N, 4, 4)`` matrices."""
    centre = np.einsum("nij,nj->ni", matrices[:, :3, :3], (lo + hi) / 2.0) + matrices[:, :3, 3]
    half = np.einsum("nij,nj->ni", np.abs(matrices[:, :3, :3]), (hi - lo) / 2.0)
    return centre - half, centre + half


def touches_sphere(boxes: Boxes, centre: NDArray[np.float64], radius: float) -> NDArray[np.bool_]:
    """Return ``(N,)``: whether a box comes within ``radius`` of ``centre (3,)``."""
    lo, hi = boxes
    gap = np.maximum(np.maximum(lo - centre, centre - hi), 0.0)
    return np.asarray((gap**2).sum(axis=1) <= radius**2)
