"""The arena's ring: sand, wall, stands with spectators, pillars with flags, broken columns, braziers."""

from dataclasses import replace

import numpy as np

from supersampling.scenes.arena.materials import Materials
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import barrel, crate
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, lathe, quad

RADIUS = 14.0
SIDES = 48
BRAZIERS = ((-3.03, 1.9, -5.7), (6.35, 1.9, 1.12))
COLUMNS = ((6.5, 30), (6.4, 75), (6.5, 160), (6.4, 250), (6.5, 305))  # radius and direction (degrees)


def planar(shape: Shape) -> Shape:
    """Set the uv of a floor to metres along x and z."""
    return replace(shape, uv=shape.positions[:, [0, 2]])


def _wall(radius: float, low: float, high: float) -> Shape:
    """Return a ring wall that looks inwards."""
    return lathe([(radius, low), (radius, high)], SIDES).map_uv((1, -1))


def ring(b: Builder, m: Materials) -> None:
    """Add sand with lime lines, the wall with its coping, stands, an arcade above them."""
    b.put(planar(lathe([(0, 0), (5.0, 0), (10.0, 0), (RADIUS, 0)], SIDES)), m.sand)
    for inner, outer in ((2.6, 2.75), (8.2, 8.4), (12.3, 12.45)):
        b.put(planar(lathe([(inner, 0.008), (outer, 0.008)], SIDES * 2)), m.lime)
    for k in range(12):
        line = box((5.4, 0.008, 0.14), (5.5, 0.004, 0), ("top",)).turn_y(30 * k + 10)
        b.put(planar(line), m.lime)
    b.put(_wall(RADIUS, 0.0, 2.3), m.stone)
    b.put(_wall(RADIUS - 0.06, 0.0, 0.35), m.brick)
    for y, deep in ((0.4, 0.1), (2.35, 0.22)):
        b.put(
            lathe([(RADIUS - deep, y - 0.12), (RADIUS - deep, y), (RADIUS + 0.3, y)], SIDES),
            m.stone,
            (0.85, 0.82, 0.78),
        )
    steps = [(RADIUS + 0.3, 2.35)]
    for k in range(6):
        steps += [(RADIUS + 0.3 + 0.95 * k, 2.5 + 0.5 * k), (RADIUS + 1.25 + 0.95 * k, 2.5 + 0.5 * k)]
    b.put(lathe(steps, SIDES), m.brick, (0.8, 0.8, 0.82))
    back = RADIUS + 6.2
    b.put(_wall(back, 4.6, 8.2), m.stone, (0.9, 0.88, 0.85))
    b.put(lathe([(back - 0.4, 7.9), (back - 0.4, 8.3), (back + 0.4, 8.3)], SIDES), m.brick)
    for k in range(SIDES):
        a = 360 / SIDES * (k + 0.5)
        b.put(box((0.5, 3.2, 0.6), (back - 0.2, 6.3, 0)).turn_y(a), m.stone)
        if k % 3 == 0:
            board = quad((0.62, 7.3, 0), (-1.24, 0, 0), (0, -1.7, 0)).turn_y(90).shift(back - 0.06, 0, 0)
            b.put(board.turn_y(a + 3.75), m.boards[k % 4])


def crowd(b: Builder, m: Materials) -> None:
    """Add seated spectators in coloured coats."""
    rng = np.random.default_rng(3)
    body = lathe([(0.0, 0.86), (0.1, 0.84), (0.12, 0.72), (0.07, 0.66), (0.24, 0.56), (0.2, 0.0)], 7)
    for tier in range(6):
        radius = RADIUS + 0.95 + 0.95 * tier
        for angle in np.arange(0, 360, 62 / radius):
            if rng.random() < 0.72:
                tone = rng.uniform(0.25, 1.0, 3) * rng.uniform(0.5, 1.0)
                place = body.shift(radius + rng.uniform(-0.15, 0.15), 2.5 + 0.5 * tier, 0).turn_y(float(angle))
                b.put(place, m.cloth, (float(tone[0]), float(tone[1]), float(tone[2])))


def trim(b: Builder, m: Materials) -> None:
    """Add pillars with flags, boards on the wall, gates."""
    for k in range(16):
        a = 22.5 * k
        pillar = [box((0.7, 3.1, 0.9), (RADIUS - 0.1, 1.55, 0)), box((0.9, 0.25, 1.1), (RADIUS - 0.15, 3.2, 0))]
        pillar.append(box((0.85, 0.5, 1.05), (RADIUS - 0.12, 0.25, 0)))
        b.put(join(pillar).turn_y(a), m.stone, (0.95, 0.93, 0.9))
        b.put(
            lathe([(0.0, 0.5), (0.16, 0.4), (0.22, 0.22), (0.1, 0.0)], 16).shift(RADIUS - 0.15, 3.3, 0).turn_y(a),
            m.steel,
        )
        flag = quad((-0.34, 2.95, 0), (0.68, 0, 0), (0, -2.4, 0)).turn_y(-90).shift(RADIUS - 0.5, 0, 0)
        b.put(flag.turn_y(a), m.flags[k % 2])
        b.put(beam((RADIUS - 0.52, 2.97, -0.42), (RADIUS - 0.52, 2.97, 0.42), 0.05).turn_y(a), m.iron)
        middle = a + 11.25
        if k % 4 == 2:
            bars = [cylinder(0.035, 2.1, 8).shift(0, 1.05, z) for z in np.linspace(-0.9, 0.9, 9)]
            bars += [beam((0, y, -1.0), (0, y, 1.0), 0.06) for y in (0.5, 1.3, 2.0)]
            b.put(join(bars).shift(RADIUS - 0.35, 0, 0).turn_y(middle), m.iron)
            b.put(box((0.4, 0.25, 2.4), (RADIUS - 0.2, 2.15, 0)).turn_y(middle), m.oak)
            b.put(
                quad((-1.0, 2.1, 0), (2.0, 0, 0), (0, -2.1, 0)).turn_y(-90).shift(RADIUS - 0.2, 0, 0).turn_y(middle),
                m.iron,
            )
        else:
            for z in (-0.85, 0.85):
                material = m.rules if (k + (z > 0)) % 5 == 0 else m.boards[(k + 2 * (z > 0)) % 4]
                board = quad((-0.7, 0.7, 0), (1.4, 0, 0), (0, -1.4, 0)).turn_y(-90).shift(RADIUS - 0.16, 1.3, z)
                b.put(board.turn_y(middle), material)
                rim = [box((0.08, 1.5, 0.06), (0, 0, s * 0.73)) for s in (-1, 1)]
                rim += [box((0.08, 0.06, 1.5), (0, s * 0.73, 0)) for s in (-1, 1)]
                b.put(join(rim).shift(RADIUS - 0.17, 1.3, z).turn_y(middle), m.oak)


def obstacles(b: Builder, m: Materials) -> None:
    """Add broken columns, a dais in the middle, braziers, crates, barrels."""
    for k, (radius, degrees) in enumerate(COLUMNS):
        tall = (2.6, 1.3, 3.1, 2.0, 1.0)[k]
        shaft = lathe([(0.0, tall + 0.05), (0.2, tall), (0.36, tall - 0.12), (0.38, 0.4)], 60, 20, 0.1)
        foot = join(
            [
                lathe([(0.38, 0.42), (0.46, 0.36), (0.44, 0.3), (0.54, 0.24), (0.54, 0.18)], 32),
                box((1.16, 0.18, 1.16), (0, 0.09, 0)),
            ]
        )
        b.put(shaft.shift(radius, 0, 0).turn_y(degrees), m.stone)
        b.put(foot.shift(radius, 0, 0).turn_y(degrees), m.stone, (0.9, 0.87, 0.82))
        drum = lathe([(0.0, 0.4), (0.36, 0.4), (0.36, -0.4), (0.0, -0.4)], 40, 20, 0.1)
        fallen = Shape(
            drum.positions[:, [1, 0, 2]] * [1, 1, -1], drum.normals[:, [1, 0, 2]] * [1, 1, -1], drum.uv, drum.triangles
        )
        if k % 2:
            b.put(fallen.turn_y(40 * k).shift(radius - 0.1, 0.36, 1.15).turn_y(degrees), m.stone)
    for radius, low, high in ((1.9, 0.0, 0.22), (1.5, 0.22, 0.44), (1.1, 0.44, 0.66)):
        b.put(lathe([(0.0, high), (radius, high), (radius, low)], 8).turn_y(22.5), m.stone)
    spire = [(0.0, 4.4), (0.1, 4.2), (0.34, 1.5), (0.5, 1.4), (0.5, 1.2), (0.4, 1.1), (0.44, 0.7), (0.6, 0.66)]
    b.put(lathe(spire, 8).turn_y(22.5), m.steel)
    for k in range(4):
        board = quad((-0.3, 0.3, 0), (0.6, 0, 0), (0, -0.6, 0)).shift(0, 0.98, 0.72)
        b.put(board.turn_y(90 * k), m.boards[k])
        b.put(box((0.66, 0.66, 0.08), (0, 0.98, 0.67)).turn_y(90 * k), m.oak)
    _braziers(b, m)
    for k, (radius, degrees) in enumerate(((13.2, 33), (13.1, 38), (13.2, 124), (13.0, 213), (13.2, 218), (13.1, 302))):
        b.put(crate(0.7, 2 * k).turn_y(10 * k).shift(radius, 0.35, 0).turn_y(degrees), m.crates)
        if k % 2:
            b.put(crate(0.5, 3 * k).turn_y(25).shift(radius, 0.95, 0).turn_y(degrees), m.crates)
        x, z = 13.2 * np.cos(np.radians(-degrees - 5)), 13.2 * np.sin(np.radians(-degrees - 5))
        b.put(barrel((x, 0, z)), m.oak)


def _braziers(b: Builder, m: Materials) -> None:
    for x, y, z in BRAZIERS:
        bowl = lathe([(0.42, 0.0), (0.4, -0.02), (0.3, -0.2), (0.08, -0.3), (0.06, -1.0), (0.09, -1.05)], 20)
        b.put(bowl.shift(x, y - 0.35, z), m.iron)
        b.put(lathe([(0.0, 0.14), (0.2, 0.08), (0.4, -0.02)], 14).shift(x, y - 0.35, z), m.embers)
        for k in range(3):
            a = 2 * np.pi * k / 3
            b.put(
                beam(
                    (x + 0.07 * np.cos(a), 0.9, z + 0.07 * np.sin(a)),
                    (x + 0.4 * np.cos(a), 0.0, z + 0.4 * np.sin(a)),
                    0.05,
                ),
                m.iron,
            )
