"""Shapes of machines and steelwork for the foundry, and the motion of its conveyor. Metric uv as in `shapes`."""

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.motion import rotation, translation
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, tube
from supersampling.scenes.kit.wheels import disc
from supersampling.scenes.scene import Array, Transform


def meshing_phase(teeth: int, phase: float, count: int, direction: float) -> float:
    """Return the phase of a wheel of ``count`` teeth that meshes with another wheel, in ``direction`` from it.

    The other wheel has ``teeth`` and ``phase``.
    """
    share = (direction - phase) * teeth / (2 * np.pi)
    return float(direction + np.pi - (0.5 - share) * 2 * np.pi / count)


def flange(radius: float, axis: str) -> Shape:
    """Return a bolted disc around a pipe at the origin."""
    parts = [disc(radius * 1.5, 0.09, (0, 0, 0), "z")]
    for i in range(8):
        a = np.pi / 4 * (i + 0.5)
        parts.append(disc(radius * 0.12, 0.15, (radius * 1.27 * np.cos(a), radius * 1.27 * np.sin(a), 0), "z", 6))
    shape = join(parts)
    if axis == "x":
        shape = shape.turn_y(90)
    elif axis == "y":
        shape = shape.turn((1, 0, 0), 90)
    return shape


def pipe(corners: ArrayLike, radius: float, bend: float = 0.3) -> Shape:
    """Return a tube through ``corners (N, 3)`` whose bends are rounded."""
    line = np.asarray(corners, float)
    points = [line[:1]]
    share = np.linspace(0, 1, 7)[:, None]
    for a, b, c in zip(line[:-2], line[1:-1], line[2:]):
        p, q = b + bend * (a - b) / np.linalg.norm(a - b), b + bend * (c - b) / np.linalg.norm(c - b)
        points.append((1 - share) ** 2 * p + 2 * share * (1 - share) * b + share**2 * q)
    return tube(np.concatenate([*points, line[-1:]]), radius, 14)


def hand_wheel(radius: float, centre: ArrayLike) -> Shape:
    """Return a valve wheel that looks along +z."""
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1) * radius
    parts = [tube(ring, 0.022, 8, True), disc(0.05, 0.09, (0, 0, 0), segments=12)]
    for a in (0.4, 0.4 + 2 * np.pi / 3, 0.4 + 4 * np.pi / 3):
        parts.append(beam((0, 0, 0), (radius * np.cos(a), radius * np.sin(a), 0), 0.025))
    return join(parts).shift(*np.asarray(centre, float))


def ladder(foot: ArrayLike, height: float, width: float = 0.45) -> Shape:
    """Return an upright ladder whose rungs run along x."""
    parts = [cylinder(0.025, height, 8).shift(s * width / 2, height / 2, 0) for s in (-1, 1)]
    parts += [disc(0.018, width, (0, y, 0), "x", 8) for y in np.arange(0.25, height - 0.05, 0.28)]
    return join(parts).shift(*np.asarray(foot, float))


def truss(half_span: float, low: float, high: float, bays: int = 10) -> Shape:
    """Return a roof truss across z at x = 0."""
    z = np.linspace(-half_span, half_span, bays + 1)
    parts = [beam((dx, low, -half_span), (dx, low, half_span), 0.05, 0.14) for dx in (-0.06, 0.06)]
    parts.append(beam((0, high, -half_span), (0, high, half_span), 0.16, 0.12))
    for i in range(bays):
        ends = (low, high) if i % 2 else (high, low)
        parts.append(beam((0, ends[0], z[i]), (0, ends[1], z[i + 1]), 0.05))
        parts.append(beam((0, low, z[i]), (0, high, z[i]), 0.035))
        parts.append(box((0.02, 0.26, 0.3), (0, low + 0.06, z[i])))
    return join(parts)


def blades(count: int, radius: float) -> Shape:
    """Return a fan wheel about the z axis: pitched blades of two skins, and a hub."""
    parts = [disc(0.2 * radius, 0.3 * radius, (0, 0, 0))]
    for i in range(count):
        blade = box((0.3 * radius, 0.84 * radius, 0.02), (0, 0.57 * radius, 0))
        parts.append(blade.turn((0, 1, 0), 32).turn((0, 0, 1), 360 / count * i))
    return join(parts)


def chain_links(length: float, link: float = 0.13) -> Shape:
    """Return a chain that hangs down from the origin."""
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    oval = np.stack([0.34 * link * np.cos(angle), 0.62 * link * np.sin(angle), 0 * angle], 1)
    shape = tube(oval, 0.014, 7, True)
    count = int(length / (0.98 * link))
    return join([shape.turn_y(90 * (i % 2)).shift(0, -(i + 0.5) * 0.98 * link, 0) for i in range(count)])


def hook(length: float) -> Shape:
    """Return a crane block and hook at the end of a chain of ``length``."""
    angle = np.radians(np.linspace(90, -160, 24))
    bow = np.stack([0.17 * np.cos(angle), 0.17 * np.sin(angle) - 0.5, 0 * angle], 1)
    line = np.concatenate([[[0, -0.12, 0], [0, -0.22, 0]], bow])
    block = box((0.24, 0.3, 0.16), (0, -0.05, 0))
    wheels = [disc(0.15, 0.04, (0, -0.03, z)) for z in (-0.1, 0.1)]
    return join([block, *wheels, tube(line, 0.04, 12), disc(0.05, 0.09, (*line[-1][:2], 0), "y", 12)]).shift(
        0, -length, 0
    )


def oval(half: float, radius: float, distance: float) -> tuple[float, float, float]:
    """Return x, z and the heading in radians on an oval of two straights ``2 * half`` long and two half circles."""
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
    """Return steady travel around an `oval` in metres per second, the object turning with the way."""
    place = translation(centre)

    def pose(seconds: float) -> Array:
        x, z, heading = oval(half, radius, start + speed * seconds)
        return (place @ translation((x, 0, z)) @ rotation((0, 1, 0), heading)).astype(np.float32)

    return pose
