"""Shapes of machines and steelwork for the foundry, and the motion of its conveyor. Metric uv as in `shapes`."""

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.motion import rotation, translation
from supersampling.scenes.kit.shapes import (
    ALL,
    Floats,
    Shape,
    beam,
    box,
    cylinder,
    grid,
    join,
    lathe,
    panel,
    plate,
    quad,
    tube,
)
from supersampling.scenes.scene import Array, Transform


def turned(shape: Shape, axis: ArrayLike, degrees: float) -> Shape:
    return shape.at(rotation(axis, np.radians(degrees)))


def disc(radius: float, depth: float, at: ArrayLike, axis: str = "z", segments: int = 24) -> Shape:
    """Cylinder of which ``axis`` is the axis, at a centre."""
    shape = cylinder(radius, depth, segments)
    if axis != "y":
        shape = turned(shape, (1, 0, 0) if axis == "z" else (0, 0, -1), 90)
    return shape.shift(*np.asarray(at, float))


def gear(teeth: int, module: float, depth: float, spokes: int = 5) -> Shape:
    """Spur wheel about the z axis, its pitch radius ``module * teeth / 2``; a tooth points along +x."""
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
    """The closed `plate` between two outlines of many points, without a loop over them."""
    a, b = np.concatenate([outer, outer[:1]]), np.concatenate([inner, inner[:1]])
    parts = []
    for z in (depth / 2, -depth / 2):
        rows = np.stack([a, b] if z < 0 else [a[::-1], b[::-1]])
        points = np.concatenate([rows, np.full((*rows.shape[:2], 1), z)], -1)
        parts.append(grid(points, np.broadcast_to([0.0, 0.0, np.sign(z)], points.shape), rows * [np.sign(z), -1]))
    return [*parts, _band(a, depth), _band(b[::-1], depth)]


def _band(line: Floats, depth: float) -> Shape:
    """Flat-shaded wall along a polyline ``(N, 2)`` of distinct points that has the solid on its left."""
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


def meshing_phase(teeth: int, phase: float, other: int, direction: float) -> float:
    """Phase of a wheel of ``other`` teeth that meshes with one of ``teeth`` and ``phase``, in ``direction`` from it."""
    share = (direction - phase) * teeth / (2 * np.pi)
    return float(direction + np.pi - (0.5 - share) * 2 * np.pi / other)


def flange(radius: float, axis: str) -> Shape:
    """Bolted disc around a pipe at the origin."""
    parts = [disc(radius * 1.5, 0.09, (0, 0, 0), "z")]
    for i in range(8):
        a = np.pi / 4 * (i + 0.5)
        parts.append(disc(radius * 0.12, 0.15, (radius * 1.27 * np.cos(a), radius * 1.27 * np.sin(a), 0), "z", 6))
    shape = join(parts)
    if axis == "x":
        shape = shape.turn_y(90)
    elif axis == "y":
        shape = turned(shape, (1, 0, 0), 90)
    return shape


def pipe(corners: ArrayLike, radius: float, bend: float = 0.3) -> Shape:
    """Tube through ``corners (N, 3)`` whose bends are rounded."""
    line = np.asarray(corners, float)
    points = [line[:1]]
    share = np.linspace(0, 1, 7)[:, None]
    for a, b, c in zip(line[:-2], line[1:-1], line[2:]):
        p, q = b + bend * (a - b) / np.linalg.norm(a - b), b + bend * (c - b) / np.linalg.norm(c - b)
        points.append((1 - share) ** 2 * p + 2 * share * (1 - share) * b + share**2 * q)
    return tube(np.concatenate([*points, line[-1:]]), radius, 14)


def hand_wheel(radius: float, at: ArrayLike) -> Shape:
    """Valve wheel that looks along +z."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1) * radius
    parts = [tube(ring, 0.022, 8, True), disc(0.05, 0.09, (0, 0, 0), segments=12)]
    for a in (0.4, 0.4 + 2 * np.pi / 3, 0.4 + 4 * np.pi / 3):
        parts.append(beam((0, 0, 0), (radius * np.cos(a), radius * np.sin(a), 0), 0.025))
    return join(parts).shift(*np.asarray(at, float))


def barrel(at: ArrayLike) -> Shape:
    """Steel drum that stands at ``at``, 0.9 m high, with two hoops."""
    x, y, z = np.asarray(at, float)
    profile = [(0, 0.87), (0.27, 0.87), (0.29, 0.9), (0.3, 0.88), (0.3, 0.62), (0.325, 0.6), (0.3, 0.58)]
    profile += [(0.3, 0.32), (0.325, 0.3), (0.3, 0.28), (0.3, 0.0)]
    return lathe(profile, 32).shift(x, y, z)


def ladder(foot: ArrayLike, height: float, width: float = 0.45) -> Shape:
    """Upright ladder whose rungs run along x."""
    parts = [cylinder(0.025, height, 8).shift(s * width / 2, height / 2, 0) for s in (-1, 1)]
    parts += [disc(0.018, width, (0, y, 0), "x", 8) for y in np.arange(0.25, height - 0.05, 0.28)]
    return join(parts).shift(*np.asarray(foot, float))


def fence(a: ArrayLike, b: ArrayLike, height: float) -> tuple[Shape, Shape]:
    """(alpha-tested mesh, frame) between two feet."""
    start, end = np.asarray(a, float), np.asarray(b, float)
    up = np.array([0.0, height, 0.0])
    low = np.array([0.0, 0.12, 0.0])
    count = max(round(float(np.linalg.norm(end - start)) / 1.4), 1)
    frame = [
        beam(start + share * (end - start), start + share * (end - start) + up, 0.05)
        for share in np.linspace(0, 1, count + 1)
    ]
    for lift in (up, low, up * 0.52):
        frame.append(beam(start + lift, end + lift, 0.035))
    return panel(start + up, end - start, low - up, (2, count)), join(frame)


def truss(half_span: float, low: float, high: float, bays: int = 10) -> Shape:
    """Roof truss across z at x = 0."""
    z = np.linspace(-half_span, half_span, bays + 1)
    parts = [beam((dx, low, -half_span), (dx, low, half_span), 0.05, 0.14) for dx in (-0.06, 0.06)]
    parts.append(beam((0, high, -half_span), (0, high, half_span), 0.16, 0.12))
    for i in range(bays):
        ends = (low, high) if i % 2 else (high, low)
        parts.append(beam((0, ends[0], z[i]), (0, ends[1], z[i + 1]), 0.05))
        parts.append(beam((0, low, z[i]), (0, high, z[i]), 0.035))
        parts.append(box((0.02, 0.26, 0.3), (0, low + 0.06, z[i])))
    return join(parts)


def crate(size: float, cell: int, cells: int = 4) -> Shape:
    """Cube about its middle whose faces show one cell of a `lettering.label_sheet`."""
    share = 1 / cells
    faces = [f for f in ALL if f != "bottom"]
    return box((size,) * 3, faces=faces, fit=True).map_uv(
        (share, share), (cell % cells * share, cell // cells % cells * share)
    )


def blades(count: int, radius: float) -> Shape:
    """Fan wheel about the z axis: pitched blades of two skins, and a hub."""
    parts = [disc(0.2 * radius, 0.3 * radius, (0, 0, 0))]
    for i in range(count):
        blade = box((0.3 * radius, 0.84 * radius, 0.02), (0, 0.57 * radius, 0))
        parts.append(turned(turned(blade, (0, 1, 0), 32), (0, 0, 1), 360 / count * i))
    return join(parts)


def ring(radius: float, thick: float, depth: float, segments: int = 48) -> Shape:
    """Flat ring about the z axis."""
    angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    around = np.stack([np.cos(angle), np.sin(angle)], 1)
    return plate(around * (radius + thick), around * radius, depth, True)


def chain_links(length: float, link: float = 0.13) -> Shape:
    """Chain that hangs down from the origin."""
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    oval = np.stack([0.34 * link * np.cos(angle), 0.62 * link * np.sin(angle), 0 * angle], 1)
    one = tube(oval, 0.014, 7, True)
    count = int(length / (0.98 * link))
    return join([one.turn_y(90 * (i % 2)).shift(0, -(i + 0.5) * 0.98 * link, 0) for i in range(count)])


def hook(length: float) -> Shape:
    """Crane block and hook at the end of a chain of ``length``."""
    angle = np.radians(np.linspace(90, -160, 24))
    bow = np.stack([0.17 * np.cos(angle), 0.17 * np.sin(angle) - 0.5, 0 * angle], 1)
    line = np.concatenate([[[0, -0.12, 0], [0, -0.22, 0]], bow])
    block = box((0.24, 0.3, 0.16), (0, -0.05, 0))
    wheels = [disc(0.15, 0.04, (0, -0.03, z)) for z in (-0.1, 0.1)]
    return join([block, *wheels, tube(line, 0.04, 12), disc(0.05, 0.09, (*line[-1][:2], 0), "y", 12)]).shift(
        0, -length, 0
    )


def oval(half: float, radius: float, distance: float) -> tuple[float, float, float]:
    """Place on an oval of two straights ``2 * half`` long and two half circles: x, z and heading in radians."""
    bend = np.pi * radius
    d = distance % (4 * half + 2 * bend)
    if d < 2 * half:
        return d - half, radius, 0.0
    d -= 2 * half
    if d < bend:
        a = d / radius
        return half + radius * np.sin(a), radius * np.cos(a), a
    d -= bend
    if d < 2 * half:
        return half - d, -radius, np.pi
    a = (d - 2 * half) / radius
    return -half - radius * np.sin(a), -radius * np.cos(a), np.pi + a


def circuit(centre: ArrayLike, half: float, radius: float, speed: float, start: float) -> Transform:
    """Steady travel around an `oval` in metres a second, the object turning with the way."""
    place = translation(centre)

    def at(seconds: float) -> Array:
        x, z, heading = oval(half, radius, start + speed * seconds)
        return (place @ translation((x, 0, z)) @ rotation((0, 1, 0), heading)).astype(np.float32)

    return at


def sign(at: ArrayLike, width: float, height: float, facing: str) -> Shape:
    """Picture 3 cm in front of a wall, uv from 0 to 1, with its middle at ``at``; ``facing`` is where it looks."""
    right = {"+z": (1, 0, 0), "-z": (-1, 0, 0), "+x": (0, 0, -1), "-x": (0, 0, 1)}[facing]
    out = np.cross(right, (0, 1, 0))
    corner = np.asarray(at, float) + 0.03 * out - 0.5 * width * np.array(right) + np.array([0, height / 2, 0])
    return quad(corner, np.multiply(right, width), (0, -height, 0))
