"""Triangle shapes to build places from: grids, boxes, lathes, tubes and plates, with metric texture coordinates.

A shape's uv are metres (u right and v down as seen from the front) unless a function says otherwise; the builder
divides them by a material's tile size. Front faces are counter-clockwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supersampling.scenes.kit.motion import rotation

Floats = NDArray[np.float64]
Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles: ``positions (N, 3)``, unit ``normals (N, 3)``, ``uv (N, 2)``, ``triangles (M, 3)``."""

    positions: Floats
    normals: Floats
    uv: Floats
    triangles: NDArray[np.int64]

    def transform(self, matrix: Floats) -> "Shape":
        """Move by a rigid ``(4, 4)`` matrix."""
        turn = matrix[:3, :3]
        return Shape(self.positions @ turn.T + matrix[:3, 3], self.normals @ turn.T, self.uv, self.triangles)

    def shift(self, x: float, y: float, z: float) -> "Shape":
        return Shape(self.positions + np.array([x, y, z]), self.normals, self.uv, self.triangles)

    def turn_y(self, degrees: float) -> "Shape":
        """Rotate about the vertical axis, counter-clockwise as seen from above."""
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        matrix = np.eye(4)
        matrix[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
        return self.transform(matrix)

    def turn(self, axis: ArrayLike, degrees: float) -> "Shape":
        """Rotate about ``axis`` through the origin (right-hand rule)."""
        return self.transform(rotation(axis, np.radians(degrees)))

    def map_uv(self, scale: tuple[float, float], offset: tuple[float, float] = (0.0, 0.0)) -> "Shape":
        return Shape(self.positions, self.normals, self.uv * scale + offset, self.triangles)


def atlas_cell(columns: int, rows: int, index: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the uv scale and offset of one cell of an atlas."""
    return (1 / columns, 1 / rows), ((index % columns) / columns, (index // columns % rows) / rows)


def join(shapes: Sequence[Shape]) -> Shape:
    """Join several shapes into one."""
    starts = np.cumsum([0] + [len(s.positions) for s in shapes[:-1]])
    return Shape(
        np.concatenate([s.positions for s in shapes]),
        np.concatenate([s.normals for s in shapes]),
        np.concatenate([s.uv for s in shapes]),
        np.concatenate([s.triangles + start for s, start in zip(shapes, starts)]),
    )


def grid(points: Floats, normals: Floats, uv: Floats) -> Shape:
    """Return the surface through ``points (R, C, 3)``, without its empty triangles.

    Rows run down and columns right, as seen from the front.
    """
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    flat = points.reshape(-1, 3)
    p, q, r = (flat[triangles[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(q - p, r - p), axis=1)
    return Shape(flat, normals.reshape(-1, 3), uv.reshape(-1, 2), triangles[area > 1e-9])


def quad(corner: ArrayLike, right: ArrayLike, down: ArrayLike, cells: tuple[int, int] = (1, 1)) -> Shape:
    """Return a flat panel from its top-left ``corner``; uv run from 0 to 1. ``cells`` are (rows, columns)."""
    start, x, y = (np.asarray(v, float) for v in (corner, right, down))
    v, u = np.meshgrid(np.linspace(0, 1, cells[0] + 1), np.linspace(0, 1, cells[1] + 1), indexing="ij")
    normal = np.cross(x, -y)
    points = start + u[..., None] * x + v[..., None] * y
    return grid(points, np.broadcast_to(normal / np.linalg.norm(normal), points.shape), np.stack([u, v], -1))


def panel(corner: ArrayLike, right: ArrayLike, down: ArrayLike, cells: tuple[int, int] = (1, 1)) -> Shape:
    """Return a `quad` with metric uv that continue across neighbouring panels of one plane."""
    x, y = np.asarray(right, float), np.asarray(down, float)
    flat = quad(corner, x, y, cells)
    axes = np.stack([x / np.linalg.norm(x), y / np.linalg.norm(y)], 1)
    return Shape(flat.positions, flat.normals, flat.positions @ axes, flat.triangles)


_FACES = {
    "front": ((1, 0, 0), (0, -1, 0)),
    "back": ((-1, 0, 0), (0, -1, 0)),
    "right": ((0, 0, -1), (0, -1, 0)),
    "left": ((0, 0, 1), (0, -1, 0)),
    "top": ((1, 0, 0), (0, 0, 1)),
    "bottom": ((1, 0, 0), (0, 0, -1)),
}
ALL = tuple(_FACES)


def box(size: ArrayLike, centre: ArrayLike = (0, 0, 0), faces: Sequence[str] = ALL, fit: bool = False) -> Shape:
    """Return a box with metric uv, or with the uv of every face from 0 to 1 (``fit``).

    ``front`` looks along +z, ``right`` along +x.
    """
    extent, middle = np.asarray(size, float), np.asarray(centre, float)
    sides = []
    for face in faces:
        right, down = (np.asarray(v, float) for v in _FACES[face])
        normal = np.cross(right, -down)
        corner = middle + (normal - right - down) * extent / 2
        sides.append((quad if fit else panel)(corner, right * extent, down * extent))
    return join(sides)


def beam(a: ArrayLike, b: ArrayLike, width: float, height: float | None = None) -> Shape:
    """Return a rectangular bar from ``a`` to ``b``; u runs across, v along it, in metres."""
    start, end = np.asarray(a, float), np.asarray(b, float)
    along = end - start
    length = float(np.linalg.norm(along))
    bar = box((width, length, height or width), (0, length / 2, 0))
    return bar.transform(_frame(start, along / length))


def _frame(origin: Floats, up: Floats) -> Floats:
    """Return the rigid matrix that takes +y to ``up`` and the origin to ``origin``."""
    helper = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = np.cross(up, helper)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([x, up, np.cross(x, up)], 1)
    matrix[:3, 3] = origin
    return matrix


def lathe(profile: ArrayLike, segments: int = 24, flutes: int = 0, depth: float = 0.0) -> Shape:
    """Return the profile ``(R, 2)`` of (radius, y), from top to bottom, turned about the y axis.

    u is arc length at the mean radius. ``flutes`` vertical grooves of relative ``depth`` are cut where the profile runs
    straight down. Edges of more than 40 degrees stay sharp.
    """
    points = np.asarray(profile, float)
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1)
    flat = np.stack([-step[:, 1], step[:, 0]], 1) / length[:, None]
    travelled = np.concatenate([[0.0], np.cumsum(length)])
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    mean = max(float(points[:, 0].mean()), 1e-3)
    parts = []
    for i in range(len(step)):
        pair = []
        for j, neighbour in ((i, i - 1), (i + 1, i + 1)):
            normal = flat[i].copy()
            if 0 <= neighbour < len(step) and flat[i] @ flat[neighbour] > 0.766:
                normal += flat[neighbour]
            pair.append((points[j], normal / np.linalg.norm(normal), travelled[j]))
        groove = depth * (0.5 - 0.5 * np.cos(flutes * angle)) if abs(step[i, 0]) < 0.2 * length[i] else 0 * angle
        slope = np.gradient(groove, angle) if groove.any() else groove
        rows, normals, uv = [], [], []
        for point, normal, v in pair:
            radius = point[0] * (1 - groove)
            rows.append(np.stack([radius * np.sin(angle), 0 * angle + point[1], radius * np.cos(angle)], 1))
            tilt = angle - np.arctan2(-slope, 1 - groove)
            n = np.stack([normal[0] * np.sin(tilt), 0 * angle + normal[1], normal[0] * np.cos(tilt)], 1)
            normals.append(n)
            uv.append(np.stack([angle * mean, 0 * angle + v], 1))
        parts.append(grid(np.array(rows), np.array(normals), np.array(uv)))
    return join(parts)


def cylinder(radius: float, height: float, segments: int = 12, caps: bool = True) -> Shape:
    """Return an upright cylinder, centred."""
    side = [(radius, height / 2), (radius, -height / 2)]
    return lathe([(0, height / 2), *side, (0, -height / 2)] if caps else side, segments)


def sphere(radius: float, segments: int = 24) -> Shape:
    angle = np.linspace(0, np.pi, segments // 2 + 1)
    return lathe(np.stack([radius * np.sin(angle), radius * np.cos(angle)], 1), segments)


def tube(path: ArrayLike, radius: float, sides: int = 6, closed: bool = False) -> Shape:
    """Return a round tube along ``path (P, 3)``, without caps; u around it, v along it, in metres."""
    line = np.asarray(path, float)
    if closed:
        line = np.concatenate([line, line[:1]])
    ends = np.concatenate([line[-2:-1], line, line[1:2]]) if closed else None
    tangent = (ends[2:] - ends[:-2]) if ends is not None else np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.empty_like(line)
    last = _frame(line[0], tangent[0])[:3, 0]
    for i, t in enumerate(tangent):
        last = last - t * (last @ t)
        last = last / np.linalg.norm(last)
        side[i] = last
    across = np.cross(tangent, side)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    around = np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * across[:, None]
    v = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    uv = np.stack(np.broadcast_arrays(angle[None] * radius, -v[:, None]), -1)
    # Rows must run against the tangent for the outside to be the front.
    return grid((line[:, None] + radius * around)[::-1], around[::-1], uv[::-1])


def plate(outer: ArrayLike, inner: ArrayLike, depth: float, closed: bool = False) -> Shape:
    """Return a flat ribbon between two polylines ``(N, 2)`` of the xy plane, ``depth`` thick about z = 0.

    Both run counter-clockwise as seen from +z (right to left for an arch: ``outer`` is its top). Metric uv.
    """
    a, b = np.asarray(outer, float), np.asarray(inner, float)
    if closed:
        a, b = np.concatenate([a, a[:1]]), np.concatenate([b, b[:1]])
    half = depth / 2
    faces = []
    for z in (half, -half):
        rows = np.stack([a, b] if z < 0 else [a[::-1], b[::-1]])
        points = np.concatenate([rows, np.full((*rows.shape[:2], 1), z)], -1)
        normals = np.broadcast_to([0.0, 0.0, np.sign(z)], points.shape)
        faces.append(grid(points, normals, rows * [np.sign(z), -1]))
    faces += [_wall(a, half), _wall(b[::-1], half)]
    if not closed:
        faces += [_wall(np.stack([b[0], a[0]]), half), _wall(np.stack([a[-1], b[-1]]), half)]
    return join(faces)


def _wall(line: Floats, half: float) -> Shape:
    """Return a flat-shaded side of a plate; the solid is on the left of ``line``."""
    sides = []
    for p, q in pairwise(line):
        if np.linalg.norm(q - p) > 1e-6:
            sides.append(
                quad((*p, -half), (0, 0, 2 * half), (*(q - p), 0)).map_uv((2 * half, float(np.linalg.norm(q - p))))
            )
    return join(sides)
