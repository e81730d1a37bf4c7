"""Parts of the atrium in their own frames: they stand on y = 0 and look along +z."""

from collections.abc import Sequence

import numpy as np

from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Floats, Shape, beam, box, cylinder, join, lathe, plate, quad, tube

SPRING = 3.6  # height at which the arches start
BAY = 2.8  # metres between columns
FLUTES = 20
_SHAFT = ((0.265, SPRING - 0.5), (0.285, 2.2), (0.3, 1.3), (0.31, 0.45))  # radius and height
GIRTH = 2 * np.pi * sum(radius for radius, _ in _SHAFT) / len(_SHAFT)  # what a lathe's u runs over in one turn


def column() -> tuple[Shape, Shape, Shape]:
    """Return the fluted shaft, the mouldings, and the square plinth and abacus."""
    bulge = [(0.35 + 0.09 * np.sin(a), 0.36 + 0.07 * np.cos(a)) for a in np.linspace(0.2, np.pi - 0.2, 6)]
    bell = [
        (0.4, SPRING - 0.14),
        (0.4, SPRING - 0.2),
        (0.37, SPRING - 0.27),
        (0.3, SPRING - 0.36),
        (0.27, SPRING - 0.42),
        (0.31, SPRING - 0.44),
        (0.31, SPRING - 0.48),
        (0.265, SPRING - 0.5),
    ]
    shaft = lathe(_SHAFT, 100, FLUTES, 0.12)
    rings = [lathe(bell, 32), lathe([(0.33, 0.46), *bulge, (0.42, 0.28), (0.42, 0.2)], 32)]
    leaves = [
        beam(
            (0.29 * np.sin(a), SPRING - 0.4, 0.29 * np.cos(a)),
            (0.42 * np.sin(a), SPRING - 0.15, 0.42 * np.cos(a)),
            0.05,
        )
        for a in np.arange(12) * np.pi / 6
    ]
    square = [box((0.94, 0.2, 0.94), (0, 0.1, 0)), box((0.9, 0.14, 0.9), (0, SPRING - 0.07, 0))]
    return shaft, join([*rings, *leaves]), join(square)


def arch(height: float) -> tuple[Shape, Shape]:
    """Return a spandrel wall of one bay up to ``height`` above the springing, and the moulded ring of voussoirs."""
    half, radius = BAY / 2, 1.03
    angle = np.linspace(0, np.pi, 25)
    inner = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    outer = np.stack([np.cos(angle) * half, np.full(25, height)], 1)
    sides = np.array([[half, 0.0], [-half, 0.0]])
    wall = plate(np.concatenate([sides[:1], outer, sides[1:]]), np.concatenate([inner[:1], inner, inner[-1:]]), 0.5)
    ring = plate(inner * 1.16, inner * 0.985, 0.62)
    key = box((0.22, 0.42, 0.7), (0, radius + 0.12, 0))
    teeth = [
        box((0.1, 0.07, 0.66), (0, radius * 1.16, 0)).transform(rotation((0, 0, 1), a - np.pi / 2))
        for a in angle[1:-1:2]
        if abs(a - np.pi / 2) > 0.15
    ]
    return wall.shift(0, SPRING, 0), join([ring, key, *teeth]).shift(0, SPRING, 0)


def railing(width: float, height: float = 1.0) -> Shape:
    """Return an iron railing with rings between its balusters."""
    count = int(width / 0.12)
    xs = np.linspace(-width / 2, width / 2, count + 1)
    bars = [beam((x, 0, 0), (x, height, 0), 0.018) for x in xs]
    bars += [beam((-width / 2, y, 0), (width / 2, y, 0), 0.03) for y in (0.08, height - 0.16, height)]
    circle = np.linspace(0, 2 * np.pi, 13)[:-1]
    middle = (xs[1:] + xs[:-1]) / 2
    rings = [
        tube(
            np.stack([x + 0.055 * np.cos(circle), height - 0.08 + 0.055 * np.sin(circle), 0 * circle], 1),
            0.008,
            4,
            True,
        )
        for x in middle
    ]
    return join(bars + rings)


def screen(width: float, height: float) -> tuple[Shape, Shape]:
    """Return a lattice panel (uv in metres) and the wooden frame that holds it."""
    panel = quad((-width / 2, height, 0), (width, 0, 0), (0, 0.15 - height, 0)).map_uv((width, height))
    posts = [box((0.09, height + 0.12, 0.09), (x, height / 2 + 0.06, 0)) for x in (-width / 2, 0, width / 2)]
    rails = [box((width, 0.08, 0.07), (0, y, 0)) for y in (0.12, height)]
    return panel, join(posts + rails)


def plant(rng: np.random.Generator, height: float = 1.1) -> tuple[Shape, Shape, Shape]:
    """Return a pot, soil with stems, and cards of foliage."""
    pot = lathe([(0.24, 0.5), (0.32, 0.5), (0.33, 0.44), (0.29, 0.42), (0.3, 0.25), (0.2, 0.04), (0.22, 0.0)], 24)
    soil = [lathe([(0, 0.47), (0.27, 0.46)], 16)]
    cards = []
    for k in range(26):
        turn, lean = rng.uniform(0, 2 * np.pi), rng.uniform(0.15, 0.9)
        size = rng.uniform(0.4, 0.6)
        card = quad((-size / 2, size, 0), (size, 0, 0), (0, -size, 0), (2, 1)).map_uv(
            (0.5, 0.5), (k % 4 * 0.25, k % 3 * 0.3)
        )
        base = np.array([0.0, rng.uniform(0.5, height - 0.3), 0.0])
        cards.append(card.transform(rotation((0, 1, 0), turn) @ rotation((1, 0, 0), lean)).shift(*base))
        if k % 4 == 0:
            soil.append(beam((0, 0.46, 0), (0.12 * np.sin(turn), height, 0.12 * np.cos(turn)), 0.018))
    return pot, join(soil), join(cards)


def bench() -> tuple[Shape, Shape]:
    """Return stone feet and slats."""
    feet = join([box((0.14, 0.42, 0.46), (x, 0.21, 0)) for x in (-0.8, 0.8)])
    slats = [box((2.0, 0.04, 0.09), (0, 0.44, z)) for z in (-0.2, -0.1, 0.0, 0.1, 0.2)]
    slats += [box((2.0, 0.09, 0.03), (0, y, -0.24)) for y in (0.6, 0.72, 0.84)]
    slats += [box((0.06, 0.5, 0.04), (x, 0.65, -0.275)) for x in (-0.8, 0.8)]
    return feet, join(slats)


def lantern() -> tuple[Shape, Shape]:
    """Return the iron cage of a lantern that hangs from the origin by ``1 m`` of chain, and its glass."""
    cage = [beam((x, -1.42, z), (x, -1.0, z), 0.025) for x in (-0.13, 0.13) for z in (-0.13, 0.13)]
    cage += [box((0.32, 0.04, 0.32), (0, y, 0)) for y in (-1.0, -1.42)]
    cage += [lathe([(0.02, -0.82), (0.2, -0.98)], 8), cylinder(0.012, 0.84, 6).shift(0, -0.42, 0)]
    cage += [box((0.29, 0.012, 0.012), (0, y, z)) for y in (-1.13, -1.28) for z in (-0.135, 0.135)]
    return join(cage), box((0.24, 0.36, 0.24), (0, -1.21, 0), ("front", "back", "left", "right"), True)


def sagging(a: Sequence[float], b: Sequence[float], sag: float) -> Floats:
    """Return the points of a cable from ``a`` to ``b`` that sags by ``sag``."""
    t = np.linspace(0, 1, 17)[:, None]
    line = (1 - t) * np.asarray(a, float) + t * np.asarray(b, float)
    line[:, 1] -= (4 * sag * t * (1 - t))[:, 0]
    return line
