"""Pieces that both scenes use: crates, carts, railings, banners, figures, lamps, pictures on walls."""

import numpy as np
from numpy.typing import ArrayLike

from ..scene import Transform
from .builder import Builder
from .motion import chain, spin, sway, translation, turned
from .shapes import Shape, beam, box, cylinder, join, lathe, plate, quad, sphere, tube


def cell(shape: Shape, index: int, columns: int, rows: int) -> Shape:
    """Squeezes uv of [0, 1] into one cell of an atlas."""
    return shape.map_uv((1 / columns, 1 / rows), (index % columns / columns, index // columns / rows))


def crate(size: float, index: int) -> Shape:
    """Cube that stands on its origin, all sides one cell of a 4 x 4 label sheet."""
    return cell(box((size, size, size), (0, size / 2, 0), fit=True), index, 4, 4)


def picture_frame(width: float, height: float, edge: float = 0.06) -> tuple[Shape, Shape]:
    """A picture (uv 0 to 1) on the plane z = 0.02 and its frame, centred, facing +z."""
    w, h = width / 2, height / 2
    bars = [
        box((width + 2 * edge, edge, 0.06), (0, s * (h + edge / 2), 0.03)) for s in (1, -1)
    ] + [box((edge, height, 0.06), (s * (w + edge / 2), 0, 0.03)) for s in (1, -1)]
    return quad((-w, h, 0.02), (width, 0, 0), (0, -height, 0)), join(bars)


def railing(a: ArrayLike, b: ArrayLike, height: float, spacing: float = 0.15) -> Shape:
    """Iron railing between two floor points: rails, posts and thin balusters with a knob each."""
    start, end = np.asarray(a, float), np.asarray(b, float)
    up = np.array([0, height, 0])
    parts = [beam(start + up, end + up, 0.06), beam(start + up * 0.12, end + up * 0.12, 0.03), beam(start + up * 0.82, end + up * 0.82, 0.025)]
    count = max(int(np.linalg.norm(end - start) / spacing), 1)
    for i in range(count + 1):
        foot = start + (end - start) * i / count
        thick = 0.05 if i % 8 == 0 else 0.016
        parts.append(beam(foot, foot + up, thick))
        if i % 8 and i % 2:
            parts.append(box((0.045, 0.045, 0.045), foot + up * 0.5))
    return join(parts)


def banner(b: Builder, material: int, top: ArrayLike, width: float, height: float, turn: float = 0.0, phase: float = 0.0) -> None:
    """Cloth of hinged strips that sways like a wave; text reads from both sides."""
    strips = 6
    step = height / strips
    motion: Transform = turned(0.0, sway((0, 0, 0), (1, 0, 0), 5.0, 0.31, phase))
    place = spin(top, (0, 1, 0), 0.0, np.radians(turn))
    for k in range(strips):
        front = quad((-width / 2, 0, 0.004), (width, 0, 0), (0, -step, 0), (1, 4))
        both = join([front, front.turn_y(180)]).map_uv((1, 1 / strips), (0, k / strips))
        b.move([(both, material)], chain(place, motion))
        motion = chain(motion, sway((0, -step, 0), (1, 0, 0), 7.0, 0.31, phase - 0.9 * (k + 1)))


def wheel(radius: float, width: float = 0.06, spokes: int = 8) -> Shape:
    """Spoked wheel in the xy plane."""
    angle = np.linspace(0, 2 * np.pi, 25)[:-1]
    rim = np.stack([np.cos(angle), np.sin(angle)], 1) * radius
    bars = [beam((0, 0, 0), (*(rim[24 * k // spokes] * 0.95), 0), 0.035) for k in range(spokes)]
    hub = cylinder(radius * 0.18, width * 1.6, 10)
    turn = np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    return join([plate(rim, rim * 0.86, width, closed=True), hub.at(turn), *bars])


def cart(b: Builder, body: int, metal: int, labels: int, motion: Transform, roll: float, cycle: float) -> None:
    """Cart of crates along x with four rolling wheels; ``roll`` is the amplitude of the wheels' turn (half the travel / radius)."""
    parts = [(box((1.5, 0.08, 0.8), (0, 0.5, 0)), body), (crate(0.5, 3).shift(-0.42, 0.54, 0), labels)]
    parts += [(crate(0.42, 6).turn_y(14).shift(0.15, 0.54, 0.12), labels), (crate(0.3, 9).turn_y(-9).shift(-0.4, 1.04, 0.02), labels)]
    parts += [(crate(0.26, 12).turn_y(25).shift(0.55, 0.54, -0.15), labels)]
    parts += [(beam((0.7, 0.5, s * 0.3), (1.0, 1.05, s * 0.3), 0.035), metal) for s in (-1, 1)]
    parts += [(beam((1.0, 1.05, -0.32), (1.0, 1.05, 0.32), 0.035), metal)]
    b.move(parts, motion)
    amplitude = np.degrees(roll)
    for x in (-0.5, 0.5):
        for z in (-0.44, 0.44):
            # Half a cosine of travel: the wheels turn back and forth in step with it.
            turn = sway((x, 0.28, z), (0, 0, -1), amplitude, cycle, -np.pi / 2)
            b.move([(wheel(0.28), metal)], chain(motion, turn))


def figure(b: Builder, coat: int, skin: int, path: Transform, pace: float, phase: float = 0.0) -> None:
    """Walking figure of 1.75 m that looks along +x of ``path``'s frame, with swinging arms and legs."""
    lower = [(0.02, 1.42), (0.13, 1.42), (0.24, 1.3), (0.2, 1.05), (0.27, 0.55), (0.25, 0.52), (0.02, 0.55)]
    hat = lathe([(0, 1.86), (0.11, 1.84), (0.12, 1.72), (0.22, 1.7), (0.22, 1.685), (0.02, 1.69)], 18)
    b.move([(lathe(lower, 20), coat), (hat, coat), (sphere(0.12, 16).shift(0, 1.6, 0), skin), (cylinder(0.05, 0.16, 8).shift(0, 1.46, 0), skin)], path)
    for side in (1, -1):
        leg = join([beam((0, 0, 0), (0, -0.7, 0), 0.12), box((0.28, 0.09, 0.12), (0.06, -0.7, 0))])
        arm = join([beam((0, 0, 0), (0, -0.36, 0), 0.1), beam((0, -0.34, 0), (0.1, -0.62, 0), 0.08)])
        b.move([(leg, coat)], chain(path, sway((0, 0.75, side * 0.1), (0, 0, 1), 24, pace, phase + side * np.pi / 2)))
        b.move([(arm, coat)], chain(path, sway((0, 1.36, side * 0.26), (0, 0, 1), 20, pace, phase - side * np.pi / 2)))


def lantern(b: Builder, metal: int, glow: int, top: ArrayLike, drop: float, phase: float) -> None:
    """Hanging lantern that swings: chain, cage and glowing core."""
    links = [tube(_ring(0.035, (k % 2) * 90.0) - [0, 0.03 + 0.055 * k, 0], 0.008, 5, True) for k in range(int(drop / 0.055))]
    cage = [beam((0.13 * c, -drop, 0.13 * s), (0.17 * c, -drop - 0.42, 0.17 * s), 0.014) for c, s in _around(8)]
    lid = lathe([(0, -drop + 0.12), (0.2, -drop), (0.2, -drop - 0.02), (0.02, -drop)], 16)
    foot = lathe([(0.02, -drop - 0.42), (0.19, -drop - 0.42), (0.19, -drop - 0.46), (0, -drop - 0.46)], 16)
    core = lathe([(0.02, -drop - 0.06), (0.09, -drop - 0.1), (0.11, -drop - 0.3), (0.03, -drop - 0.4)], 14)
    parts = [(join([*links, *cage, lid, foot]), metal), (core, glow)]
    b.move(parts, chain(sway(top, (1, 0, 0), 4, 0.37, phase), sway((0, 0, 0), (0, 0, 1), 6, 0.29, phase * 1.7)))


def _around(count: int) -> list[tuple[float, float]]:
    return [(float(np.cos(a)), float(np.sin(a))) for a in np.arange(count) * 2 * np.pi / count]


def _ring(radius: float, turn: float) -> np.ndarray:
    """Closed upright circle of 8 points about the origin, turned about y."""
    points = np.array([(radius * 0.7 * c, radius * s, 0) for c, s in _around(8)])
    angle = np.radians(turn)
    return points @ np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])


def placed(motion: Transform, offset: ArrayLike, turn: float = 0.0) -> Transform:
    """``motion`` followed by a fixed offset and turn inside its frame."""
    fixed = spin(offset, (0, 1, 0), 0.0, np.radians(turn))
    return chain(motion, fixed)


__all__ = ["banner", "cart", "cell", "crate", "figure", "lantern", "picture_frame", "placed", "railing", "translation", "wheel"]
