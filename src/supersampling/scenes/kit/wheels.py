"""Round parts of machines: discs, rings, hoops, spoked wheels and spur gears. Metric uv as in `shapes`."""

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Floats, Shape, beam, box, cylinder, grid, join, plate


def disc(radius: float, depth: float, centre: ArrayLike, axis: str = "z", segments: int = 24) -> Shape:
    """Return a cylinder about ``axis``, its middle at ``centre``."""
    shape = cylinder(radius, depth, segments)
    if axis != "y":
        shape = shape.turn((1, 0, 0) if axis == "z" else (0, 0, -1), 90)
    return shape.shift(*np.asarray(centre, float))


def ring(radius: float, thick: float, depth: float, segments: int = 48) -> Shape:
    """Return a flat ring about the z axis."""
    angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    around = np.stack([np.cos(angle), np.sin(angle)], 1)
    return plate(around * (radius + thick), around * radius, depth, True)


def hoop(radius: float, thick: float, wide: float) -> Shape:
    """Return a flat ring about z, with a graduation on its outside every six degrees."""
    circle = np.linspace(0, 2 * np.pi, 61)[:-1]
    mark = box((0.012, 0.012, wide + 0.01), (radius + 0.004, 0, 0))
    return join([_ring(radius, thick, wide), *(mark.transform(rotation((0, 0, 1), a)) for a in circle)])


def _ring(radius: float, thick: float, wide: float) -> Shape:
    circle = np.linspace(0, 2 * np.pi, 61)[:-1]
    rim = np.stack([np.cos(circle), np.sin(circle)], 1)
    return plate(rim * radius, rim * (radius - thick), wide, True)


def wheel(radius: float) -> tuple[Shape, Shape]:
    """Return the tyre with spokes about z, and the hub."""
    spokes = [beam((0, 0, 0), (radius * np.cos(a), radius * np.sin(a), 0), 0.025) for a in np.arange(10) * np.pi / 5]
    return join([_ring(radius, 0.04, 0.06), *spokes]), cylinder(0.05, 0.12, 10).transform(
        rotation((1, 0, 0), np.pi / 2)
    )


def gear(teeth: int, module: float, depth: float, spokes: int = 5) -> Shape:
    """Return a spur wheel about the z axis, its pitch radius ``module * teeth / 2``; a tooth points along +x."""
    radius = module * teeth / 2
    root, tip, rim = radius - 1.2 * module, radius + 0.9 * module, radius - 2.6 * module
    share = np.array([-0.5, -0.3, -0.28, -0.22, -0.13, 0.13, 0.22, 0.28, 0.3])
    reach = np.array([root, root, root, radius, tip, tip, radius, root, root])
    angle = (2 * np.pi / teeth * (np.arange(teeth)[:, None] + share)).ravel()
    length = np.tile(reach, teeth)
    around = np.stack([np.cos(angle), np.sin(angle)], 1)
    hub = max(0.22 * radius, 2.2 * module)
    parts = _rim(around * length[:, None], around * rim, depth)
    for i in range(spokes):
        a = 2 * np.pi * (i + 0.3) / spokes
        way = np.array([np.cos(a), np.sin(a), 0])
        parts.append(beam(way * hub * 0.8, way * (rim + 0.02), 0.28 * radius, depth * 0.55))
    parts.append(disc(hub, depth * 1.5, (0, 0, 0), segments=32))
    parts.append(disc(hub * 0.45, depth * 2.4, (0, 0, 0)))
    for i in range(6):
        a = np.pi / 3 * i
        parts.append(disc(hub * 0.09, depth * 1.7, (hub * 0.75 * np.cos(a), hub * 0.75 * np.sin(a), 0), segments=8))
    return join(parts)


def _rim(outer: Floats, inner: Floats, depth: float) -> list[Shape]:
    """Return the closed `plate` between two outlines of many points, without a loop over the points."""
    a, b = np.concatenate([outer, outer[:1]]), np.concatenate([inner, inner[:1]])
    parts = []
    for z in (depth / 2, -depth / 2):
        rows = np.stack([a, b] if z < 0 else [a[::-1], b[::-1]])
        points = np.concatenate([rows, np.full((*rows.shape[:2], 1), z)], -1)
        parts.append(grid(points, np.broadcast_to([0.0, 0.0, np.sign(z)], points.shape), rows * [np.sign(z), -1]))
    return [*parts, _band(a, depth), _band(b[::-1], depth)]


def _band(line: Floats, depth: float) -> Shape:
    """Return a flat-shaded wall along ``line (N, 2)`` of distinct points; the solid is on its left."""
    step = np.diff(line, axis=0)
    length = np.linalg.norm(step, axis=1)
    count = len(step)
    corners = np.stack([line[:-1], line[:-1], line[1:], line[1:]], 1)
    z = np.broadcast_to(np.array([-1.0, 1.0, 1.0, -1.0])[:, None] * depth / 2, (count, 4, 1))
    out = np.stack([step[:, 1], -step[:, 0], 0 * length], 1) / length[:, None]
    along = np.cumsum(length)
    v = np.stack([along - length, along - length, along, along], 1)
    u = np.broadcast_to([0.0, depth, depth, 0.0], v.shape)
    triangles = np.arange(count)[:, None, None] * 4 + np.array([[0, 2, 1], [0, 3, 2]])
    return Shape(
        np.concatenate([corners, z], -1).reshape(-1, 3),
        np.repeat(out, 4, axis=0),
        np.stack([u, v], -1).reshape(-1, 2),
        triangles.reshape(-1, 3),
    )
