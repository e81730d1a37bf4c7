"""Slowly moving parts of the market: signs on their brackets, banners, bunting, and a hand cart."""

from collections.abc import Sequence

import numpy as np

from supersampling.scenes.kit.blocks import beam, box, quad
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.motion import chain, fixed, rotation, shuttle, sway, translation
from supersampling.scenes.kit.shapes import Point, Shape, atlas_cell, join, tube
from supersampling.scenes.kit.wheels import wheel
from supersampling.scenes.market.materials import Palette

LANE, REACH, HERTZ = (-12.6, 6.0, 1 / 90)  # the cart's lane x, how far it goes to both sides, its journeys a second
WHEEL = 0.36


def hanging_sign(b: Builder, p: Palette, number: int, anchor: Point, turn: float) -> None:
    """Add a sign that hangs out from a wall, at ``anchor`` on it; ``turn`` is that of the wall."""
    place = translation(anchor) @ rotation((0, 1, 0), np.radians(turn))
    bracket = [
        beam((0, 0, 0), (0, 0, 1.05), 0.035),
        beam((0, -0.5, 0), (0, -0.02, 0.85), 0.025),
        box((0.05, 0.7, 0.05), (0, -0.2, 0.02)),
    ]
    bracket += [beam((0, 0.3, 0), (0, 0.0, 1.0), 0.015)]
    b.put(join(bracket).transform(place), p.iron)
    faces = [quad((0, -0.12, 0.3), (0, 0, -0.62), (0, -0.62, 0)), quad((0, -0.12, -0.32), (0, 0, 0.62), (0, -0.62, 0))]
    boards = join([faces[0].shift(0.021, 0, 0), faces[1].shift(-0.021, 0, 0)])
    frame = [
        box((0.035, 0.66, 0.66), (0, -0.43, -0.01)),
        *(beam((0, 0.0, z), (0, -0.12, z), 0.014) for z in (-0.2, 0.2)),
    ]
    hinge = place @ translation((0, -0.02, 0.62))
    motion = sway((0, 0, 0), (0, 0, 1), 5.0 + number, 0.31 + 0.03 * number, 1.7 * number)
    b.move([(boards, p.signs[number]), (join(frame), p.iron)], chain(fixed(hinge), motion))


def banner(b: Builder, p: Palette, number: int, anchor: Point, turn: float) -> None:
    """Add cloth on a pole that stands out from a wall."""
    place = translation(anchor) @ rotation((0, 1, 0), np.radians(turn))
    b.put(beam((0, 0, 0), (0, 0, 1.3), 0.05).transform(place), p.wood)
    cloth = quad((0, 0, 0.42), (0, 0, -0.84), (0, -3.2, 0))
    hinge = place @ translation((0, -0.04, 0.75))
    motion = sway((0, 0, 0), (0, 0, 1), 4.0, 0.23, 2.0 * number)
    b.move([(cloth, p.banners[number % 2])], chain(fixed(hinge), motion))


def bunting(b: Builder, p: Palette, ends: tuple[Point, Point], seed: int, sag: float = 0.9) -> None:
    """Add a line of pennants that swings as a whole about the line through its ends."""
    start, end = (np.asarray(e, float) for e in ends)
    length = float(np.linalg.norm(end - start))
    t = np.linspace(0, 1, 25)
    line = np.stack([t * length, -4 * sag * t * (1 - t), 0 * t], 1)
    flags: list[Shape] = []
    count = int(length / 0.42)
    for k in range(count):
        s = (k + 0.5) / count
        x, y = s * length, -4 * sag * s * (1 - s)
        corners = np.array([(x - 0.15, y, 0), (x + 0.15, y, 0), (x, y - 0.36, 0)])
        uv = (np.array([(0.05, 0), (0.95, 0), (0.5, 1.0)]) + np.array(((k + seed) % 4, 0))) * (0.25, 1)
        flags.append(Shape(corners, np.tile([0.0, 0.0, 1.0], (3, 1)), uv, np.array([[0, 2, 1]])))
    along = (end - start) / length
    up = np.array([0.0, 1.0, 0.0]) - along * along[1]
    up /= np.linalg.norm(up)
    place = np.eye(4)
    place[:3, :3] = np.stack([along, up, np.cross(along, up)], 1)
    place[:3, 3] = start
    motion = sway((0, 0, 0), (1, 0, 0), 9.0, 0.27 + 0.02 * seed, 1.1 * seed)
    b.move([(tube(line, 0.008, 4), p.iron), (join(flags), p.bunting)], chain(fixed(place), motion))


def cart(b: Builder, p: Palette) -> None:
    """Add a hand cart with crates and sacks that rolls to and fro along the west side; its wheels roll with it."""
    sides = [box((0.9, 0.06, 1.7), (0, 0.62, 0)), *(box((0.04, 0.3, 1.7), (x, 0.78, 0)) for x in (-0.45, 0.45))]
    sides += [box((0.9, 0.3, 0.04), (0, 0.78, z)) for z in (-0.84, 0.84)]
    sides += [beam((x, 0.6, 0.8), (x, 0.86, 1.7), 0.05) for x in (-0.3, 0.3)] + [
        beam((-0.36, 0.86, 1.68), (0.36, 0.86, 1.68), 0.04)
    ]
    sides += [beam((x, 0.6, -0.6), (x, 0.04, -0.66), 0.05) for x in (-0.36, 0.36)] + [
        beam((-0.56, WHEEL, 0), (0.56, WHEEL, 0), 0.06)
    ]
    load: list[Shape] = []
    for k, (x, y, z) in enumerate(
        ((-0.2, 0.65, -0.5), (0.22, 0.65, -0.45), (-0.18, 0.65, 0.05), (0.2, 0.65, 0.5), (0.0, 1.03, -0.4))
    ):
        load.append(
            box((0.4, 0.38, 0.4), (0, 0.19, 0), fit=True)
            .map_uv(*atlas_cell(4, 4, 3 * k))
            .turn_y(9 * k - 12)
            .shift(x, y, z)
        )
    ride = shuttle((LANE, 0, -REACH), (LANE, 0, REACH), HERTZ)
    b.move([(join(sides), p.wood), (join(load), p.crates)], ride)
    rim, hub = wheel(WHEEL)

    def roll(seconds: float) -> np.ndarray:
        travelled = ride(seconds)[2, 3]
        return rotation((1, 0, 0), travelled / WHEEL).astype(np.float32)

    for x in (-0.54, 0.54):
        axle = translation((x, WHEEL, 0))
        parts = [(rim.turn_y(90), p.wood), (hub.turn_y(90), p.iron)]
        b.move(parts, chain(ride, fixed(axle), roll))


def movers(b: Builder, p: Palette, signs: Sequence[tuple[Point, float]]) -> None:
    """Add all moving objects; ``signs`` are places on walls and the turns of those walls."""
    for k, (anchor, turn) in enumerate(signs):
        hanging_sign(b, p, k, anchor, turn)
    for k, z in enumerate((-2.2, 2.2)):
        banner(b, p, k, (14.9, 8.2, z), -90)
    lines: tuple[tuple[Point, Point], ...] = (
        ((-9.5, 6.2, -9.9), (-5.0, 6.2, 9.9)),
        ((-1.0, 6.4, -9.9), (2.0, 6.2, 9.9)),
        ((8.0, 6.3, -9.9), (6.0, 6.2, 9.9)),
    )
    for k, ends in enumerate(lines):
        bunting(b, p, ends, k)
    cart(b, p)
