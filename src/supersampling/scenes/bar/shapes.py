"""Shapes that the bar is drawn with: mouldings along a line, rounded lines, neon tubes and a ball of mirrors."""

from itertools import pairwise

import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from numpy.typing import ArrayLike

from supersampling.scenes.kit.shapes import Floats, Shape, grid, join, quad, tube


def sweep(path: ArrayLike, profile: ArrayLike) -> Shape:
    """Return a profile ``(R, 2)`` of (out, y), from top to bottom, along a ground line ``(P, 2)`` of (x, z); metric uv.

    As seen from outside the line runs from left to right: along +x, out is +z. Edges along the line stay sharp.
    """
    line, shape = np.asarray(path, float), np.asarray(profile, float)
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    out = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    down = 0.0
    parts = []
    for a, b in pairwise(shape):
        length = float(np.linalg.norm(b - a))
        n = np.array([a[1] - b[1], b[0] - a[0]]) / length
        rows = [
            np.stack([line[:, 0] + p[0] * out[:, 0], 0 * travelled + p[1], line[:, 1] + p[0] * out[:, 1]], 1)
            for p in (a, b)
        ]
        normal = np.stack([n[0] * out[:, 0], 0 * travelled + n[1], n[0] * out[:, 1]], 1)
        uv = [np.stack([travelled, 0 * travelled + v], 1) for v in (down, down + length)]
        parts.append(grid(np.array(rows), np.array([normal, normal]), np.array(uv)))
        down += length
    return join(parts)


def rounded(corners: ArrayLike, radius: float, steps: int = 9) -> Floats:
    """Return a polyline ``(N, 2)`` whose inner corners are bends of about ``radius``."""
    line = np.asarray(corners, float)
    share = np.linspace(0, 1, steps)[:, None]
    points = [line[:1]]
    for a, b, c in zip(line[:-2], line[1:-1], line[2:]):
        p, q = b + radius * (a - b) / np.linalg.norm(a - b), b + radius * (c - b) / np.linalg.norm(c - b)
        points.append((1 - share) ** 2 * p + 2 * share * (1 - share) * b + share**2 * q)
    return np.concatenate([*points, line[-1:]])


def neon_letters(text: str, height: float) -> Shape:
    """Return the outlines of letters as glass tubes about z = 0, the text's middle at the origin."""
    outline = TextPath((0, 0), text, size=1.0, prop=FontProperties(family="DejaVu Sans", weight="bold"))
    loops = [np.asarray(p, float)[:-1] for p in outline.to_polygons(closed_only=False)]
    loops = [loop[np.linalg.norm(loop - np.roll(loop, 1, 0), axis=1) > 0.03] for loop in loops]
    points = np.concatenate(loops)
    middle = (points.max(0) + points.min(0)) / 2
    scale = height / float(np.ptp(points[:, 1]))
    return join([neon((loop - middle) * scale, closed=True) for loop in loops])


def neon(line: ArrayLike, radius: float = 0.018, closed: bool = False) -> Shape:
    """Return a glass tube along a polyline ``(N, 2)`` of the xy plane, with points at most 6 cm apart."""
    points = np.asarray(line, float)
    ends = np.concatenate([points, points[:1]]) if closed else points
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
    count = max(int(arc[-1] / 0.07), 8)
    stations = np.linspace(0, arc[-1], count + 1)[: count if closed else count + 1]
    stations = np.unique(np.concatenate([stations, arc[:-1] if closed else arc]).round(4))
    spread = np.stack([np.interp(stations, arc, ends[:, 0]), np.interp(stations, arc, ends[:, 1]), 0 * stations], 1)
    return tube(spread, radius, 4, closed)


def mirror_ball(radius: float, rows: int = 13) -> Shape:
    """Return a ball of flat facets."""
    faces = []
    for i in range(rows):
        high, low = (np.pi * (i + share) / rows for share in (0.02, 0.98))
        count = max(round(2 * rows * np.sin((high + low) / 2)), 5)
        for k in range(count):
            left, right = (2 * np.pi * (k + share) / count for share in (0.03, 0.97))
            corner, beside, below = (_on_ball(radius, a, t) for a, t in ((left, high), (right, high), (left, low)))
            flat = quad(corner, beside - corner, below - corner)
            last = _on_ball(radius, right, low)
            faces.append(
                Shape(np.stack([corner, beside, below, last]), flat.normals, flat.uv * 0.1 + 0.13 * k, flat.triangles)
            )
    return join(faces)


def _on_ball(radius: float, angle: float, polar: float) -> Floats:
    return radius * np.array([np.sin(polar) * np.sin(angle), np.cos(polar), np.sin(polar) * np.cos(angle)])
