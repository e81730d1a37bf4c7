"""The carved machine on the turntable, in its own frame: axis y, the turntable's top at y = 0."""

import numpy as np

from supersampling.scenes.kit.builder import Part
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, lathe, quad, sphere, tube
from supersampling.scenes.kit.wheels import disc, gear, hoop, ring
from supersampling.scenes.turntable.materials import Materials

RADIUS = 0.82  # of the turntable
TOP = 1.86  # height of the machine


def _band(radius: float, low: float, high: float, segments: int = 72) -> Shape:
    """Return an upright cylinder wall whose uv run once around and from top to bottom."""
    return lathe([(radius, high), (radius, low)], segments).map_uv((1 / (2 * np.pi * radius), 1 / (high - low)))


def _around(shape: Shape, count: int, first: float = 0.0) -> Shape:
    return join([shape.turn_y(first + 360 / count * k) for k in range(count)])


def _table(m: Materials) -> list[Part]:
    """Return a disc with a scale of degrees on its top and a lettered rim."""
    top = lathe([(0.0, 0.0), (0.72, 0.0)], 72)
    scale = lathe([(0.72, 0.0), (RADIUS, 0.0)], 96)
    u = scale.uv[:, 0] / scale.uv[:, 0].max()
    v = (RADIUS - np.hypot(scale.positions[:, 0], scale.positions[:, 2])) / (RADIUS - 0.72)
    scale = Shape(scale.positions, scale.normals, np.stack([u, v], 1), scale.triangles)
    return [(top, m.bronze), (scale, m.scale), (_band(RADIUS, -0.09, 0.0, 96).map_uv((2, 1)), m.bands[0])]


def _plinth(m: Materials) -> list[Part]:
    """Return an eight-sided foot: mouldings, carved panels with lettering, balusters at the corners."""
    half, low, high = 0.44, 0.1, 0.42
    side = 2 * half * np.tan(np.pi / 8)
    face = quad((-side / 2 + 0.03, high - 0.03, half), (side - 0.06, 0, 0), (0, low - high + 0.06, 0))
    panels = [(face.turn_y(45 * k), m.panels[k // 2 % 4]) for k in range(0, 8, 2)]
    scrolls = [(face.map_uv((0.3, 0.26), (0.1 * k, 0.3)).turn_y(45 * k), m.scrolls) for k in range(1, 8, 2)]
    core = _around(box((side + 0.01, high - low, 0.1), (0, (low + high) / 2, half - 0.06), ("front",)), 8)
    steps = [
        lathe([(0.0, y + h), (r, y + h), (r, y), (0.0, y)], 8).turn_y(22.5)
        for r, y, h in ((0.6, 0.0, 0.05), (0.54, 0.05, 0.05), (0.53, high, 0.04), (0.49, high + 0.04, 0.03))
    ]
    turn = [
        (0.0, 0.32),
        (0.02, 0.32),
        (0.026, 0.29),
        (0.012, 0.26),
        (0.024, 0.2),
        (0.03, 0.12),
        (0.016, 0.07),
        (0.03, 0.04),
        (0.03, 0.0),
    ]
    posts = _around(lathe(turn, 14).shift(0, low, half / np.cos(np.pi / 8)), 8, 22.5)
    return [*panels, *scrolls, (core, m.plain), (join(steps), m.oak), (posts, m.bronze)]


def _urn(m: Materials) -> list[Part]:
    """Return the body of the machine: fluted foot, carved belly, lettered shoulder, neck."""
    foot = lathe([(0.16, 0.62), (0.2, 0.56), (0.3, 0.51), (0.31, 0.49)], 96, 24, 0.08)
    t = np.linspace(0, np.pi, 15)
    belly = lathe(np.stack([0.2 + 0.17 * np.sin(t * 0.86 + 0.3), 0.62 + 0.2 * (1 - np.cos(t))], 1)[::-1], 72)
    shoulder = [lathe([(0.16, 1.12), (0.21, 1.1), (0.22, 1.08), (0.25, 1.06), (0.245, 1.02)], 64)]
    shoulder += [lathe([(0.2, 0.63), (0.24, 0.62), (0.24, 0.6), (0.18, 0.59)], 64)]
    neck = lathe([(0.1, 1.26), (0.08, 1.2), (0.12, 1.12)], 48, 16, 0.1)
    beads = _around(sphere(0.014, 8).shift(0.255, 1.04, 0), 48)
    return [
        (foot, m.plain),
        (belly, m.stone),
        (join([*shoulder, beads]), m.bronze),
        (neck, m.plain),
        (_band(0.381, 0.79, 0.86), m.bands[1]),
    ]


def _handles(m: Materials) -> list[Part]:
    """Return four scrolled brackets with leaves, between the plinth and the belly."""
    t = np.linspace(0, 3.3 * np.pi, 60)
    radius = 0.12 * np.exp(-0.17 * t)
    curl = np.stack([0.5 + radius * np.cos(t - 0.6 * np.pi), 0.98 + radius * np.sin(t - 0.6 * np.pi), 0 * t], 1)
    arm = np.stack(
        [
            0.5 + 0.06 * np.sin(np.linspace(0, 2 * np.pi, 18)) - 0.035,
            np.linspace(0.5, curl[0, 1] - 0.02, 18),
            np.zeros(18),
        ],
        1,
    )
    rod = tube(np.concatenate([arm, curl]), 0.017, 8)
    leaves = [sphere(0.04, 10).transform(rotation((0, 0, 1), a)).shift(*curl[k]) for k, a in ((8, 0.3), (24, 1.2))]
    ball = sphere(0.03, 14).shift(*curl[-1])
    stay = beam((0.37, 0.74, 0), (0.5, 0.74, 0), 0.02)
    return [(_around(join([rod, *leaves, ball, stay]), 4, 45), m.bronze)]


def _works(m: Materials) -> list[Part]:
    """Return wheels on the four sides: meshing pairs on axles out of the belly."""
    big, small = gear(40, 0.0085, 0.03, 6), gear(18, 0.0085, 0.03, 4)
    axle = disc(0.015, 0.3, (0, 0, -0.12), segments=12)
    steel = [join([small.shift(-0.21, 0.13, 0.0), axle.shift(-0.21, 0.13, 0.0)])]
    brass = [join([big, axle])]
    dial = disc(0.078, 0.002, (0, 0, 0.036), segments=40)
    dial = Shape(dial.positions, dial.normals, dial.positions[:, :2] * [6.4, -6.4] + 0.5, dial.triangles)
    rim = ring(0.077, 0.012, 0.05, 40)
    parts: list[Part] = []
    for k in range(4):
        place = (0.0, 0.66 + 0.04 * (k % 2), 0.47)
        parts += [(s.shift(*place).turn_y(90 * k), (m.bronze, m.steel)[k % 2]) for s in brass]
        parts += [(s.shift(*place).turn_y(90 * k), m.steel) for s in steel]
        parts.append((dial.shift(*place).turn_y(90 * k), m.gauges[k % 2]))
        parts.append((rim.shift(*place).turn_y(90 * k), m.bronze))
    return parts


def _sphere(m: Materials) -> list[Part]:
    """Return armillary rings about an engraved globe, and planets on long arms."""
    centre = (0.0, 1.54, 0.0)
    rings = [hoop(0.31, 0.018, 0.03), hoop(0.28, 0.014, 0.05).turn_y(90), hoop(0.25, 0.012, 0.03).turn_y(40)]
    rings.append(hoop(0.295, 0.014, 0.06).turn((1, 0, 0), 90))
    rings.append(hoop(0.27, 0.012, 0.045).turn((1, 0, 0.3), 66))
    cage = join([*rings, beam((-0.05, -0.3, 0), (0.05, 0.34, 0), 0.014)]).shift(*centre)
    globe = sphere(0.13, 48).shift(*centre)
    spire = lathe([(0.0, 0.06), (0.012, 0.04), (0.02, 0.02), (0.01, 0.0)], 16).shift(0, TOP, 0)
    arms, balls = [], []
    for k, (reach, y) in enumerate(((0.62, 1.2), (0.72, 1.32), (0.56, 1.44), (0.68, 1.62), (0.5, 1.74))):
        a = 2.4 * k
        tip = (reach * np.cos(a), y, reach * np.sin(a))
        arms.append(
            tube(
                [
                    (0.09 * np.cos(a), 1.22, 0.09 * np.sin(a)),
                    (0.5 * tip[0], 1.2, 0.5 * tip[2]),
                    (0.85 * tip[0], y - 0.06, 0.85 * tip[2]),
                    tip,
                ],
                0.007,
                6,
            )
        )
        balls.append(sphere(0.03 + 0.008 * (k % 3), 20).shift(*tip))
        halo = ring(0.055, 0.008, 0.006, 28).turn((1, 0, 0), 70).shift(*tip)
        arms.append(halo)
    stem = lathe([(0.03, 1.3), (0.045, 1.27), (0.045, 1.24), (0.07, 1.2)], 24)
    return [
        (join([cage, spire, *arms, stem]), m.bronze),
        (globe, m.scrolls),
        (join(balls[::2]), m.steel),
        (join(balls[1::2]), m.stone),
    ]


def _cresting(m: Materials) -> list[Part]:
    """Return rows of little arches and pins around the plinth's upper edge."""
    t = np.linspace(0, np.pi, 9)
    arch = tube(np.stack([0.032 * np.cos(t), 0.05 * np.sin(t), 0 * t], 1), 0.0045, 5)
    pin = join([cylinder(0.004, 0.07, 6).shift(0.032, 0.035, 0), sphere(0.009, 8).shift(0.032, 0.074, 0)])
    unit = join([arch, pin]).shift(0, 0.49, 0.45)
    return [(_around(unit, 44), m.bronze)]


def machine(m: Materials) -> list[Part]:
    """Return everything that turns."""
    return [part for make in (_table, _plinth, _urn, _handles, _works, _sphere, _cresting) for part in make(m)]
