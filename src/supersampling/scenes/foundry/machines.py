"""The foundry's machines: wheels, press, fans, crane, conveyor and furnace."""

import numpy as np

from supersampling.scenes.foundry.parts import blades, chain_links, circuit, hook, meshing_phase, oval
from supersampling.scenes.foundry.stock import Stock
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import crate, fence
from supersampling.scenes.kit.motion import chain, shuttle, spin, sway
from supersampling.scenes.kit.shapes import Point, beam, box, cylinder, join, panel
from supersampling.scenes.kit.wheels import disc, gear, ring


def _train(b: Builder, first: Point, wheels: list[tuple[int, float]], hertz: float, metals: list[int]) -> None:
    """Add meshing wheels in one plane: (teeth, direction from the previous wheel in degrees); module 0.05 m."""
    module, (x, y, z) = 0.05, first
    phase, teeth, rate = 0.0, wheels[0][0], hertz
    for i, (count, degrees) in enumerate(wheels):
        if i:
            way = np.radians(degrees)
            distance = module * (teeth + count) / 2
            x, y = x + distance * np.cos(way), y + distance * np.sin(way)
            phase, rate = meshing_phase(teeth, phase, count, way), -rate * teeth / count
            teeth = count
        b.move(
            [(gear(count, module, 0.12, 4 + i % 3), metals[i % len(metals)])], spin((x, y, z), (0, 0, 1), rate, phase)
        )
        b.put(disc(0.045, 0.5, (x, y, z - 0.1), segments=16), metals[0])


def gear_machine(b: Builder, m: Stock) -> None:
    """Add a wall of wheels behind a fence on the north side."""
    b.put(box((6.0, 3.6, 0.5), (-5.2, 1.8, -6.6)), m.green)
    b.put(box((6.3, 0.3, 0.9), (-5.2, 0.15, -6.4)), m.hazard)
    b.put(box((6.2, 0.1, 0.7), (-5.2, 3.65, -6.6)), m.tread)
    wheels = [(24, 0.0), (14, 25.0), (32, -8.0), (12, 62.0), (20, -20.0)]
    _train(b, (-7.25, 1.35, -6.12), wheels, 0.35, [m.steel, m.brass, m.iron])
    _train(b, (-6.9, 2.85, -6.12), [(16, 0.0), (12, 20.0)], 0.6, [m.brass, m.steel])
    for a, c in (
        ((-8.4, 0, -4.9), (-2.0, 0, -4.9)),
        ((-8.4, 0, -4.9), (-8.4, 0, -6.4)),
        ((-2.0, 0, -6.4), (-2.0, 0, -4.9)),
    ):
        mesh, frame = fence(a, c, 1.9)
        b.put(mesh, m.fence)
        b.put(frame, m.yellow)


def island(b: Builder, m: Stock) -> None:
    """Add winding gear in the middle of the hall, with wheels on both sides."""
    b.put(box((3.6, 0.5, 1.2), (-3.4, 0.25, -1.0)), m.red)
    b.put(box((3.8, 0.12, 1.4), (-3.4, 0.06, -1.0)), m.hazard)
    for x in (-4.9, -4.3, -2.6, -1.9):
        b.put(box((0.16, 1.7, 0.5), (x, 1.3, -1.0)), m.iron)
    b.put(disc(0.3, 2.4, (-3.4, 1.5, -1.0), "x", 40), m.steel)
    for z in (-1.34, -0.66):
        b.put(box((3.6, 0.34, 0.06), (-3.4, 1.38, z)), m.green)
    for x in (-4.1, -3.0, -2.75):
        b.put(disc(0.32, 0.06, (x, 1.5, -1.0), "x", 40), m.brass)
    _train(b, (-4.5, 1.3, -0.55), [(22, 0.0), (16, 12.0), (18, -14.0)], 0.5, [m.brass, m.steel])
    _train(b, (-2.4, 1.3, -1.45), [(20, 0.0), (20, 178.0)], -0.4, [m.steel, m.brass])


def press(b: Builder, m: Stock) -> None:
    """Add a forging press: its ram goes up and down behind a fence."""
    x, z = 4.2, -5.6
    b.put(box((2.2, 0.8, 1.4), (x, 0.4, z)), m.green)
    b.put(box((0.9, 0.2, 0.9), (x, 0.9, z)), m.steel)
    b.put(box((2.2, 0.8, 1.2), (x, 3.7, z)), m.green)
    for dx in (-0.9, 0.9):
        b.put(box((0.35, 2.6, 0.9), (x + dx, 2.0, z)), m.red)
        b.put(cylinder(0.06, 2.6, 16).shift(x + dx * 0.62, 2.0, z + 0.3), m.steel)
    b.put(cylinder(0.42, 1.2, 32).shift(x, 4.6, z), m.iron)
    ram = join(
        [
            cylinder(0.24, 2.2, 32).shift(0, 1.3, 0),
            box((1.3, 0.3, 0.8), (0, 0.2, 0)),
            box((0.7, 0.25, 0.7), (0, -0.05, 0)),
        ]
    )
    b.move([(ram, m.steel)], shuttle((x, 1.29, z), (x, 2.3, z), 0.45))
    b.put(box((0.35, 0.14, 0.35), (x, 1.03, z)), m.embers)
    for a, c in (((2.6, 0, -4.4), (5.9, 0, -4.4)), ((2.6, 0, -4.4), (2.6, 0, -6.2))):
        mesh, frame = fence(a, c, 1.5)
        b.put(mesh, m.fence)
        b.put(frame, m.yellow)


def fans(b: Builder, m: Stock) -> None:
    """Add two wall fans in cages: a large one on the east wall, a small one on the west wall."""
    for place, radius, turn, hertz in (((11.55, 2.9, -3.2), 1.2, -90.0, 1.6), ((-11.55, 3.45, 4.6), 0.8, 90.0, 2.3)):
        frame = join(
            [
                ring(radius * 1.04, 0.14, 0.4),
                *(ring(radius * s, 0.015, 0.02).shift(0, 0, 0.22) for s in (0.3, 0.6, 0.9)),
            ]
        )
        cage = [
            beam((0, 0, 0.23), (1.1 * radius * np.cos(a), 1.1 * radius * np.sin(a), 0.21), 0.02)
            for a in np.arange(12) * np.pi / 6
        ]
        b.put(join([frame, *cage]).turn_y(turn).shift(*place), m.yellow)
        back = box((2.5 * radius, 2.5 * radius, 0.06), (0, 0, -0.3)).turn_y(turn).shift(*place)
        b.put(back, m.tread)
        wheel = blades(6, radius).turn_y(turn)
        b.move([(wheel, m.red if turn < 0 else m.brass)], spin(place, (np.sign(turn), 0, 0), hertz))


def crane(b: Builder, m: Stock) -> None:
    """Add a travelling crane along x with a hook that swings on its chain, and a second, small hoist."""
    for z in (-1.45, -0.95):
        b.put(beam((-6.2, 6.05, z), (10.2, 6.05, z), 0.3, 0.12), m.yellow)
        for x in (-6.0, -2.0, 6.0, 10.0):
            b.put(box((0.1, 0.58, 0.1), (x, 6.46, z)), m.iron)
    trolley = join(
        [box((0.9, 0.3, 0.8), (0, 0, 0)), *(disc(0.14, 0.1, (x, -0.1, z)) for x in (-0.3, 0.3) for z in (-0.42, 0.42))]
    )
    travel = shuttle((0.9, 6.42, -1.2), (1.9, 6.42, -1.2), 0.1)
    b.move([(trolley, m.red)], travel)
    parts = [(chain_links(3.6), m.iron), (hook(3.7), m.yellow)]
    b.move(parts, chain(travel, sway((0, -0.1, 0), (0, 0, 1), 9.0, 0.26)))
    b.put(box((0.5, 0.3, 0.4), (-6.0, 6.42, -3.4)), m.red)
    b.put(beam((-10.0, 6.645, -3.4), (-2.0, 6.645, -3.4), 0.16, 0.1), m.iron)
    parts = [(chain_links(2.6), m.steel), (hook(2.7), m.red)]
    b.move(parts, sway((-6.0, 6.25, -3.4), (1, 0, 0.4), 7.0, 0.33, 1.0))


def conveyor(b: Builder, m: Stock) -> None:
    """Add an oval roller conveyor with labelled crates that go round."""
    half, radius, centre = 3.2, 1.2, (4.5, 0.0, 1.8)
    around = 4 * half + 2 * np.pi * radius
    count = 130
    roller = disc(0.045, 0.66, (0, 0.86, 0), "z", 12)
    for i in range(count):
        x, z, heading = oval(half, radius, around * i / count)
        b.put(roller.turn_y(np.degrees(heading)).shift(centre[0] + x, 0, centre[2] + z), m.steel)
    for reach in (radius - 0.36, radius + 0.36):
        corners = [oval(half, reach, s)[:2] for s in _stations(half, reach)]
        for (x, z), (u, w) in zip(corners, [*corners[1:], corners[0]]):
            rail = beam((centre[0] + x, 0.86, centre[2] + z), (centre[0] + u, 0.86, centre[2] + w), 0.05, 0.16)
            b.put(rail, m.yellow)
        for x, z in corners[::3]:
            b.put(beam((centre[0] + x, 0, centre[2] + z), (centre[0] + x, 0.8, centre[2] + z), 0.07), m.iron)
    for i in range(12):
        size = (0.5, 0.42, 0.56)[i % 3]
        motion = circuit((centre[0], 0.905 + size / 2, centre[2]), half, radius, 0.8, around * i / 12)
        b.move([(crate(size, i * 5), m.crates)], motion)


def _stations(half: float, radius: float) -> list[float]:
    """Return distances along an oval: even on its straights, dense on its bends."""
    bend = np.pi * radius
    straight, arc = np.linspace(0, 2 * half, 7)[:-1], np.linspace(0, bend, 13)[:-1]
    return [float(v) for v in (*straight, *(2 * half + arc), *(2 * half + bend + straight), *(4 * half + bend + arc))]


def furnace(b: Builder, m: Stock) -> None:
    """Add a brick furnace at the west end with a glowing mouth."""
    for z in (-1.7, 1.7):
        b.put(box((2.2, 3.4, 1.4), (-10.9, 1.7, z)), m.brick)
    b.put(box((2.2, 1.5, 2.0), (-10.9, 2.65, 0)), m.brick)
    b.put(box((2.2, 0.5, 2.0), (-10.9, 0.25, 0)), m.brick)
    b.put(panel((-11.4, 1.9, 1.0), (0, 0, -2.0), (0, -1.4, 0)), m.embers)
    b.put(panel((-11.4, 0.9, 1.0), (0, 0, -2.0), (1.4, -0.38, 0)), m.embers)
    for z in (-1.08, 1.08):
        b.put(box((0.12, 1.7, 0.16), (-9.8, 1.25, z)), m.iron)
    b.put(box((0.14, 0.2, 2.4), (-9.78, 2.0, 0)), m.iron)
    b.put(box((0.5, 0.1, 2.4), (-9.6, 0.5, 0)), m.tread)
    for y in (0.9, 2.4, 3.2):
        b.put(box((2.3, 0.12, 4.9), (-10.9, y, 0)) if y > 2 else box((0.06, 0.12, 1.2), (-9.78, y, 1.8)), m.iron)
    b.put(box((1.4, 4.6, 1.4), (-11.0, 5.7, 0)), m.brick)
    for y in (3.5, 4.5, 5.5, 6.5):
        b.put(box((1.48, 0.08, 1.48), (-11.0, y, 0)), m.iron)
    door = join([box((0.08, 0.9, 2.0), (0, 0, 0)), *(box((0.12, 0.9, 0.08), (0, 0, z)) for z in (-0.8, 0, 0.8))])
    b.move([(door, m.red)], shuttle((-9.72, 2.2, 0), (-9.72, 2.55, 0), 0.2))


def machines(b: Builder, m: Stock) -> None:
    for build in (gear_machine, island, press, fans, crane, conveyor, furnace):
        build(b, m)
