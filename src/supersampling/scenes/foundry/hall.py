"""The foundry's hall: floor, walls, roof, walkway, pipes, panels and lamps."""

import numpy as np

from supersampling.scenes.foundry.parts import flange, hand_wheel, ladder, pipe, truss
from supersampling.scenes.foundry.stock import Stock
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import sign
from supersampling.scenes.kit.shapes import beam, box, lathe, panel, tube
from supersampling.scenes.kit.wheels import disc
from supersampling.scenes.scene import PointLight

HALF_X, HALF_Z, HEIGHT = 12.0, 7.0, 8.0
_LAMPS = ((-2.0, 4.3, -3.6), (6.0, 4.3, -3.4), (2.0, 4.4, 4.2))


def shell(b: Builder, m: Stock) -> None:
    """Add a floor, walls and a roof with four skylights."""
    b.put(panel((-HALF_X, 0, -HALF_Z), (24, 0, 0), (0, 0, 14), (14, 24)), m.floor, (0.7, 0.7, 0.7))
    for z in (-HALF_Z, HALF_Z):
        out = np.sign(z)
        b.put(box((24.6, 5.6, 0.3), (0, 5.2, z + 0.15 * out)), m.sheet)
        b.put(box((24.6, 2.4, 0.34), (0, 1.2, z + 0.15 * out)), m.brick)
        b.put(box((24, 0.1, 0.16), (0, 2.42, z - 0.04 * out)), m.iron)
    for x in (-HALF_X, HALF_X):
        out = np.sign(x)
        b.put(box((0.3, 4.4, 14), (x + 0.15 * out, 2.2, 0)), m.brick)
        b.put(box((0.3, 3.6, 14), (x + 0.15 * out, 6.2, 0)), m.sheet)
        b.put(box((0.12, 0.16, 14), (x - 0.04 * out, 4.4, 0)), m.iron)
    for x in (-10.7, -4.7, 4.7, 10.7):
        b.put(box((2.6, 0.12, 14.6), (x, HEIGHT + 0.1, 0)), m.sheet)
    for x in (-7.7, -1.7, 1.7, 7.7):
        for z in (-5.6, 5.6):
            b.put(box((3.4, 0.12, 3.0), (x, HEIGHT + 0.1, z)), m.sheet)
        for dx in np.linspace(-1.6, 1.6, 5):
            b.put(beam((x + dx, HEIGHT, -4.2), (x + dx, HEIGHT, 4.2), 0.05), m.iron)
    roof = truss(HALF_Z, 6.75, 7.92)
    for x in np.arange(-10.0, 10.1, 4.0):
        b.put(roof.shift(x, 0, 0), m.red)
        for z in (-6.86, 6.86):
            b.put(box((0.3, 6.8, 0.26), (x, 3.4, z)), m.red)
            b.put(box((0.5, 0.08, 0.4), (x, 0.04, z)), m.iron)
    for z in np.arange(-6, 6.1, 2.0):
        b.put(beam((-HALF_X, 7.96, z), (HALF_X, 7.96, z), 0.08), m.iron)


def markings(b: Builder, m: Stock) -> None:
    """Add painted lanes on the floor, and checker plates."""
    lanes = [(-9.0, -4.45, 18.5, 0.18), (-9.0, -2.0, 18.5, 0.18), (-9.0, 3.6, 20, 0.18), (-9.0, 5.1, 20, 0.18)]
    lanes += [(-9.2, -4.45, 0.18, 9.7), (9.6, -2.0, 0.18, 5.6), (11.05, -5.5, 0.18, 11.0)]
    for x, z, width, depth in lanes:
        b.put(panel((x, 0.006, z), (width, 0, 0), (0, 0, depth)), m.hazard)
    for x, z, width, depth in (
        (-9.6, -2.4, 2.6, 4.8),
        (-1.2, -6.2, 2.4, 1.2),
        (6.4, -6.6, 2.4, 1.8),
        (0.6, -2.0, 2.0, 1.7),
    ):
        b.put(box((width, 0.02, depth), (x + width / 2, 0.01, z + depth / 2)), m.tread)


def walkway(b: Builder, m: Stock) -> None:
    """Add a grated walkway along the south wall with railings, brackets and ladders."""
    b.put(panel((-9.5, 3.1, 5.3), (19.5, 0, 0), (0, 0, 1.55), (2, 20)), m.grate)
    for z in (5.3, 6.8):
        b.put(beam((-9.5, 3.04, z), (10.0, 3.04, z), 0.08, 0.12), m.yellow)
    for y in (3.55, 4.1):
        b.put(tube([(-9.5, y, 5.3), (10.0, y, 5.3)], 0.025, 8), m.yellow)
    for x in np.linspace(-9.5, 10.0, 14):
        b.put(beam((x, 3.0, 5.3), (x, 4.12, 5.3), 0.05), m.yellow)
        b.put(beam((x, 3.02, 5.3), (x, 3.02, 6.9), 0.06), m.iron)
        b.put(beam((x, 2.95, 5.35), (x, 2.1, 6.95), 0.05), m.iron)
    b.put(ladder((-9.0, 0, 5.15), 4.1), m.steel)
    b.put(ladder((9.7, 0, 5.15), 4.1), m.steel)


def pipes(b: Builder, m: Stock) -> None:
    """Add pipes with flanges and valves along the north wall, cables under the roof."""
    for y, radius, material in ((4.3, 0.16, m.iron), (4.8, 0.1, m.brass), (5.3, 0.13, m.steel)):
        line = [(-11.6, y, -6.55), (10.6, y, -6.55), (10.6, y, -6.0), (11.7, y, -6.0)]
        b.put(pipe(line, radius), material)
        joint = flange(radius, "x")
        for x in np.arange(-10.8, 10.5, 2.4):
            b.put(joint.shift(x, y, -6.55), material)
            b.put(box((0.05, 0.08, 0.5), (x + 1.2, y - radius - 0.03, -6.75)), m.iron)
    joint = flange(0.09, "y")
    for x in (-9.6, -1.6, 2.3, 7.2, 9.4):
        b.put(pipe([(x, 4.3, -6.5), (x, 4.3, -6.2), (x, 0.0, -6.2)], 0.09, 0.15), m.brass if x > 5 else m.steel)
        b.put(joint.shift(x, 2.6, -6.2), m.iron)
        b.put(joint.shift(x, 0.05, -6.2), m.iron)
        b.put(hand_wheel(0.17, (x, 1.35, -5.95)), m.red)
        b.put(disc(0.03, 0.3, (x, 1.35, -6.08), "z", 10), m.steel)
    share = np.linspace(0, 1, 25)[:, None]
    for z, sag in ((-4.4, 0.5), (-4.25, 0.7), (0.8, 0.6), (3.6, 0.4), (3.75, 0.65)):
        for x in np.arange(-10, 9.9, 4.0):
            cable = np.array([x, 6.7, z]) + share * [4.0, 0, 0] - 4 * sag * share * (1 - share) * [0, 1, 0]
            b.put(tube(cable, 0.022, 7), m.iron)


def panels(b: Builder, m: Stock) -> None:
    """Add the gauge panel and the notices."""
    b.put(box((2.4, 1.7, 0.3), (0.1, 1.75, -6.75)), m.green)
    for i in range(15):
        x, y = -0.82 + 0.46 * (i % 5), 2.32 - 0.5 * (i // 5)
        b.put(sign((x, y, -6.6), 0.38, 0.38, "+z"), m.gauges[(i + i // 5) % 3])
        b.put(disc(0.2, 0.02, (x, y, -6.59), segments=24), m.brass)
    for place, facing, k in (
        ((-9.3, 1.7, -6.98), "+z", 0),
        ((12.0, 3.4, 1.9), "-x", 4),
        ((8.3, 1.7, -6.98), "+z", 1),
        ((-12.0, 1.8, -4.7), "+x", 2),
        ((-12.0, 1.8, 5.4), "+x", 4),
        ((12.0, 1.7, -5.7), "-x", 3),
        ((12.0, 2.0, -1.5), "-x", 0),
        ((12.0, 1.8, 5.6), "-x", 1),
        ((-9.8, 2.6, 1.7), "+x", 2),
        ((-9.8, 1.7, -1.7), "+x", 0),
        ((-6.4, 1.35, -4.9), "+z", 0),
        ((3.4, 1.0, -4.4), "+z", 2),
        ((-10.7, 1.7, 6.98), "-z", 3),
        ((10.8, 1.7, 6.98), "-z", 4),
    ):
        small = 0.5 if place[2] in (-4.9, -4.4) else 1.0
        b.put(sign(place, small, small, facing), m.notices[k])


def lamps(b: Builder, m: Stock) -> list[PointLight]:
    """Add the pendant lamps; return their lights and the furnace's glow."""
    for x, y, z in _LAMPS:
        b.put(lathe([(0.03, 0.3), (0.08, 0.28), (0.34, 0.02), (0.34, 0.0)], 32).shift(x, y, z), m.green)
        b.put(lathe([(0.0, 0.06), (0.13, 0.0), (0.1, -0.07), (0.0, -0.1)], 20).shift(x, y, z), m.lamp)
        b.put(tube([(x, y + 0.25, z), (x, 6.75, z)], 0.012, 6), m.iron)
    lights = [PointLight((x, y - 0.2, z), (26.0, 23.0, 18.0), 12.0) for x, y, z in _LAMPS]
    return [*lights, PointLight((-9.0, 1.3, 0.0), (9.0, 4.0, 1.6), 9.0)]
