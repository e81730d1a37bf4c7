"""Survey of the geometry for routes and lights: its bounds, also in motion, and points spread over its surface."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from supersampling.scenes.gltf.nodes import Matrix, NodeTransform
from supersampling.scenes.scene import Mesh

Points = NDArray[np.float64]
# Seconds at which moving objects are sampled: in the first minute, in steps that match no animation's period.
_MOMENTS = tuple((np.arange(40) * 0.618034 * 60.0 % 60.0).tolist())
_PER_MESH = 2000  # sampled triangles, at most
_SAMPLES = 16000
_STRIDE = 8  # every 8th sample is enough for visibility
_TILES = 4  # per side of each face of the cube of directions


@dataclass(frozen=True, eq=False, kw_only=True)
class Survey:
    """Bounds ``lo, hi (3,)`` and samples of the surface at time 0.

    Each of the points ``surface (N, 3)`` represents an equal part of ``area``; ``normals (N, 3)`` are unit vectors.
    """

    lo: Points
    hi: Points
    surface: Points
    normals: Points
    area: float

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.surface)

    @property
    def centre(self) -> Points:
        return 0.5 * (self.lo + self.hi)

    @property
    def radius(self) -> float:
        """Radius of the sphere around the bounds; never zero."""
        return max(0.5 * float(np.linalg.norm(self.hi - self.lo)), 1e-6)

    @property
    def spacing(self) -> float:
        """Distance between neighbouring samples of the surface, in metres."""
        return float(np.sqrt(self.area / len(self.surface)))

    def scaled(self, factor: float) -> "Survey":
        lo, hi, surface = self.lo * factor, self.hi * factor, self.surface * factor
        return Survey(lo=lo, hi=hi, surface=surface, normals=self.normals, area=self.area * factor * factor)

    def clearance(self, points: Points) -> Points:
        """Return the distance ``(P,)`` of each point to the nearest sample of the surface."""
        return np.asarray(self._tree.query(points)[0])

    def backs_seen(self, points: Points) -> Points:
        """Return for each point ``(P,)`` the share of directions whose nearest surface shows its back, in [0, 1].

        It is 1 inside a solid, and 0 in the open and in a room whose walls face inwards. A direction is a tile of a
        cube around the point.
        """
        surface, normals = self.surface[::_STRIDE], self.normals[::_STRIDE]
        shares = np.zeros(len(points))
        for k, point in enumerate(points):
            away = surface - point
            # Farthest first, so that nearer samples of the same tile overwrite it.
            order = np.argsort(-(away**2).sum(axis=1), kind="stable")
            nearest = np.full(6 * _TILES * _TILES, -1, np.int64)
            nearest[_tile(away[order])] = order
            seen = nearest[nearest >= 0]
            shares[k] = float(((away[seen] * normals[seen]).sum(axis=1) > 0.0).mean())
        return shares


def _tile(directions: Points) -> NDArray[np.int64]:
    """Return for each direction ``(N, 3)`` its tile among the ``6 * _TILES^2`` tiles of a cube."""
    axis = np.abs(directions).argmax(axis=1)
    rows = np.arange(len(directions))
    along = directions[rows, axis]
    depth = np.maximum(np.abs(along), 1e-30)  # a sample at the point itself
    across = np.stack([directions[rows, (axis + 1) % 3], directions[rows, (axis + 2) % 3]]) / depth
    u, v = np.clip(((across + 1.0) * 0.5 * _TILES).astype(np.int64), 0, _TILES - 1)
    return ((2 * axis + (along > 0.0)) * _TILES + u) * _TILES + v


def survey(meshes: Sequence[Mesh], instances: Sequence[tuple[tuple[int, ...], NodeTransform]]) -> Survey:
    """Return the survey of mesh instances, which must have at least one triangle."""
    boxes = [np.stack([m.positions.min(axis=0), m.positions.max(axis=0)]).astype(np.float64) for m in meshes]
    samples = [_sample(mesh) for mesh in meshes]
    lo, hi = np.full(3, np.inf), np.full(3, -np.inf)
    corners, weights = [], []
    for numbers, transform in instances:
        box = np.concatenate([_corners(boxes[n]) for n in numbers])
        for moment in _MOMENTS if transform.moves else (0.0,):
            moved = _transform(transform.matrix(moment), box)
            lo, hi = np.minimum(lo, moved.min(axis=0)), np.maximum(hi, moved.max(axis=0))
        matrix = transform.matrix(0.0)
        for n in numbers:
            triangles, weight = samples[n]
            corners.append(_transform(matrix, triangles.reshape(-1, 3)).reshape(-1, 3, 3))
            weights.append(np.full(len(triangles), weight))
    return _spread(lo, hi, np.concatenate(corners), np.concatenate(weights))


def _spread(lo: Points, hi: Points, triangles: Points, weights: Points) -> Survey:
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    cross = np.cross(b - a, c - a)
    length = np.linalg.norm(cross, axis=1)
    areas = 0.5 * length * weights
    total = np.cumsum(areas)
    # Equal steps of area; positions within triangles follow multiples of a generalised golden ratio.
    targets = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * total[-1]
    k = np.minimum(np.searchsorted(total, targets), len(total) - 1)
    u, v = (np.arange(_SAMPLES) * 0.7548776662) % 1.0, (np.arange(_SAMPLES) * 0.5698402910) % 1.0
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    surface = a[k] + u[:, None] * (b - a)[k] + v[:, None] * (c - a)[k]
    normals = cross[k] / np.maximum(length[k], 1e-30)[:, None]
    return Survey(lo=lo, hi=hi, surface=surface, normals=normals, area=float(total[-1]))


def _sample(mesh: Mesh) -> tuple[Points, float]:
    """Return the corners of evenly sampled triangles, and how many triangles each represents."""
    step = max(len(mesh.triangles) // _PER_MESH, 1)
    return mesh.positions[mesh.triangles[::step]].astype(np.float64), float(step)


def _corners(box: Points) -> Points:
    return np.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def _transform(matrix: Matrix, points: Points) -> Points:
    return points @ matrix[:3, :3].T + matrix[:3, 3]
