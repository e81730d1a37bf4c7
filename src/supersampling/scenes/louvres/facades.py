"""The sides of the louvred street: the pavilion of fins, the row of shops, the sheet-metal hall and the lattice."""

import numpy as np

from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, panel
from supersampling.scenes.louvres import parts
from supersampling.scenes.louvres.materials import Palette

HALF_X, NORTH, SOUTH = 16.0, -7.0, 7.0
BAYS = np.arange(8) * 4.0 - 14.0  # middles of the bays of both long sides, 4 m wide
FLOOR = 3.3  # height of the upper storey's floor


def ground(b: Builder, p: Palette) -> None:
    """Add pavers, dark bands across, drains with gratings along both sides."""
    b.put(panel((-40, 0, -30), (80, 0, 0), (0, 0, 60)), p.paving)
    for x in (-12.0, -4.0, 4.0, 12.0):
        b.put(panel((x - 0.3, 0.003, NORTH), (0.6, 0, 0), (0, 0, SOUTH - NORTH)), p.band)
    for z in (-4.7, 4.7):
        b.put(panel((-HALF_X, 0.004, z - 0.16), (2 * HALF_X, 0, 0), (0, 0, 0.32)), p.shade)
        b.put(parts.grating(2 * HALF_X, 0.3, 0.03).shift(0, 0, z), p.dark)


def pavilion(b: Builder, p: Palette) -> None:
    """Add the north side, in the sun: timber fins before white battens, tilted louvres and a balcony above."""
    z = NORTH
    b.put(panel((-HALF_X, 7.4, z - 0.8), (2 * HALF_X, 0, 0), (0, -7.4, 0)), p.clay)
    b.put(box((2 * HALF_X, 0.24, 2.0), (0, FLOOR - 0.12, z)), p.pale)
    b.put(box((2 * HALF_X, 0.12, 1.0), (0, 0.06, z - 0.1)), p.pale)
    b.put(box((2 * HALF_X + 0.4, 0.1, 2.6), (0, 6.5, z + 0.3)), p.white)
    b.put(parts.fins(2 * HALF_X, 0.55, 0.07, 0.025, 0.04).shift(0, 6.55, z + 1.4), p.ash)
    for x in np.arange(9) * 4.0 - HALF_X:
        b.put(box((0.22, 6.5, 0.3), (x, 3.25, z + 0.05)), p.white)
    for k, x in enumerate(BAYS):
        if k % 2 == 0:
            # A second layer of nearly the same period: beats that glide as one walks by.
            b.put(parts.fins(3.74, FLOOR - 0.38, 0.05, 0.022, 0.04).shift(x, 0.12, z), p.cedar)
            b.put(parts.fins(3.74, FLOOR - 0.38, 0.053, 0.026, 0.02).shift(x, 0.12, z - 0.3), p.white)
        else:
            for wood, shift in ((p.cedar, -0.023), (p.ash, 0.023)):
                low = parts.fins(3.68, FLOOR - 0.38, 0.092, 0.026, 0.045, 24)
                b.put(low.shift(x + shift, 0.12, z), wood)
        color = (p.white, p.dark, p.sage, p.white)[k % 4]
        b.put(parts.slats(3.74, 2.1, (0.06, 0.052)[k // 2 % 2], 0.01, 0.05, 32).shift(x, FLOOR + 0.95, z), color)
        b.put(box((3.74, 0.9, 0.06), (x, FLOOR + 0.45, z - 0.1), ("front", "top")), (p.mosaic, p.chess)[k % 2])
        for dx in (-1.25, 0.0, 1.25):
            b.put(box((0.05, 2.2, 0.03), (x + dx, FLOOR + 2.0, z - 0.07)), p.dark)
    b.put(parts.railing(2 * HALF_X, 1.0, 0.06).shift(0, FLOOR, z + 0.95), p.dark)


def shops(b: Builder, p: Palette) -> None:
    """Add the south side, in the shade: shops with awnings, blinds and shutters; windows with blinds and fins above."""
    for shape, material in _shop_front(p):
        b.put(shape.turn_y(180).shift(0, 0, SOUTH), material)


def _shop_front(p: Palette) -> list[tuple[Shape, int]]:
    """Return the row of shops as it looks along +z from z = 0."""
    pieces = [
        (panel((-HALF_X, 7.6, 0), (2 * HALF_X, 0, 0), (0, -7.6, 0)), p.pale),
        (box((2 * HALF_X, 0.16, 0.3), (0, FLOOR + 0.08, 0.15)), p.white),
        (box((2 * HALF_X, 0.3, 0.5), (0, 7.0, 0.25)), p.white),
        (box((2 * HALF_X, 0.4, 0.05), (0, 0.2, 0.03), ("front", "top")), p.band),
        (parts.fins(2 * HALF_X, 0.2, 0.1, 0.045, 0.08).shift(0, 6.66, 0.1), p.white),
    ]
    for k, x in enumerate(BAYS):
        pieces += _ground_floor(p, k, float(x)) + _upper_floor(p, k, float(x))
    return pieces


def _ground_floor(p: Palette, k: int, x: float) -> list[tuple[Shape, int]]:
    """Return a shop: window with a blind, pinstriped curtain or shutter; awning over most of them."""
    paint = (p.blue, p.rust, p.sage, p.mustard)[k % 4]
    pieces = [(parts.frame(3.0, 2.1).shift(x, 0.55, 0.06), paint)]
    if k % 3 == 0:
        pieces.append((parts.shutter(3.0, 2.1, 0.05).shift(x, 0.55, 0.04), p.white))
    elif k % 3 == 1:
        pieces.append((panel((x - 1.5, 2.65, 0.01), (3.0, 0, 0), (0, -2.1, 0)), p.shade))
        pieces.append((parts.slats(2.96, 2.08, 0.038, 0.005, 0.03, 30).shift(x, 0.56, 0.05), p.white))
    else:
        pieces.append((panel((x - 1.5, 2.65, 0.015), (3.0, 0, 0), (0, -2.1, 0)), p.pinstripe))
        pieces.append((box((0.06, 2.1, 0.06), (x, 1.6, 0.05)), paint))
    if k % 4 != 3:
        cloth, arms = parts.awning(3.4, 1.15, 0.55)
        pieces += [(cloth.shift(x, 3.2, 0.02), p.awnings[k % 3]), (arms.shift(x, 3.2, 0.02), p.white)]
    else:
        pieces.append((parts.fins(3.2, 0.4, 0.05, 0.02, 0.04).shift(x, 2.78, 0.06), paint))
    return pieces


def _upper_floor(p: Palette, k: int, x: float) -> list[tuple[Shape, int]]:
    """Return two windows with folding blinds of slats, or a screen of slanting fins."""
    y = FLOOR + 0.85
    pieces: list[tuple[Shape, int]] = []
    if k % 2 == 0:
        for dx in (-0.95, 0.95):
            pieces.append((parts.frame(0.95, 1.7, 0.06, 0.1).shift(x + dx, y, 0.05), p.white))
            pieces.append(
                (panel((x + dx - 0.475, y + 1.7, 0.01), (0.95, 0, 0), (0, -1.7, 0)), (p.ticking, p.shade)[k // 2 % 2])
            )
            for side in (-1, 1):
                leaf = parts.slats(0.44, 1.66, 0.038, 0.008, 0.032, 35).shift(x + dx + side * 0.75, y + 0.02, 0.05)
                pieces.append((leaf, (p.sage, p.blue, p.rust)[k // 2 % 3]))
                for edge in (-0.23, 0.23):
                    pieces.append((box((0.03, 1.74, 0.05), (x + dx + side * 0.75 + edge, y + 0.85, 0.05)), p.white))
        pieces.append((parts.railing(2.6, 0.8, 0.055, 0.006).shift(x, FLOOR + 0.16, 0.62), p.dark))
        pieces.append((box((2.8, 0.1, 0.7), (x, FLOOR + 0.11, 0.35)), p.white))
    else:
        pieces.append((panel((x - 1.6, FLOOR + 3.1, 0.02), (3.2, 0, 0), (0, -2.7, 0)), p.shade))
        pieces.append(
            (parts.fins(3.2, 2.7, 0.055, 0.012, 0.05, 40).shift(x, FLOOR + 0.4, 0.08), (p.mustard, p.rust)[k // 2 % 2])
        )
        pieces += [(box((3.4, 0.1, 0.2), (x, yy, 0.1)), p.white) for yy in (FLOOR + 0.35, FLOOR + 3.15)]
    return pieces


def hall(b: Builder, p: Palette) -> None:
    """Add the east end: a hall of corrugated sheets with ventilation louvres, behind a wire fence."""
    pieces = [(parts.corrugated(16.0, 5.2, 0.065, 0.022).shift(0, 1.0, 0), p.sage)]
    pieces.append((box((16.0, 1.0, 0.2), (0, 0.5, 0), ("front", "top")), p.band))
    for k in range(4):
        x = -6.0 + 4.0 * k
        pieces.append((box((3.9, 0.1, 1.4), (x, 6.25 + 0.35, -0.5)), p.white))
        pieces.append((parts.slats(3.8, 0.9, 0.06, 0.01, 0.05, 35).shift(x, 6.3 + 0.35, 0.05), p.white))
        pieces.append((panel((x - 1.9, 7.6, -0.05), (3.8, 0, 0), (0, -1.0, 0)), p.shade))
        pieces.append((parts.frame(1.8, 1.2, 0.08, 0.16).shift(x, 2.6, 0.05), p.white))
        pieces.append((panel((x - 0.9, 3.8, 0.03), (1.8, 0, 0), (0, -1.2, 0)), p.shade))
        pieces.append((parts.slats(1.8, 1.2, 0.048, 0.01, 0.04, 35).shift(x, 2.6, 0.07), p.dark))
    for x in (-4.5, -1.5, 1.5, 4.5):
        wires, bars = parts.framed_mesh(2.98, 2.0, 0.045)
        pieces += [(wires.shift(x, 0, 2.2), p.dark), (bars.shift(x, 0, 2.2), p.dark)]
    for shape, material in pieces:
        b.put(shape.turn_y(-90).shift(HALF_X + 1.0, 0, 0), material)


def lattice(b: Builder, p: Palette) -> None:
    """Add the west end: a tower of level slats between two screens of crossing battens."""
    pieces = [(parts.corrugated(16.0, 4.4, 0.08, 0.03).shift(0, 0, -1.2), p.rust)]
    for x in (-4.4, 4.4):
        # Trellis: two layers of slanting battens.
        for side in (-1, 1):
            battens = [
                beam((u, 0.2, 0.03 * side), (u + side * 2.6, 2.8, 0.03 * side), 0.024, 0.012)
                for u in np.arange(-1.9, 2.0, 0.08)
            ]
            pieces += [(s.shift(x - side * 1.3, 0, 0), p.ash) for s in battens]
        pieces += [(box((0.14, 3.0, 0.16), (x + s * 2.2 * 1.5, 1.5, 0)), p.white) for s in (-1, 1)]
        pieces += [(box((6.7, 0.14, 0.2), (x, y, 0)), p.white) for y in (0.13, 2.87)]
    for k in range(4):
        face = parts.slats(2.0, 8.0, 0.06, 0.016, 0.04, 20).shift(0, 0.2, 1.0)
        pieces.append((face.turn_y(90 * k), p.cedar))
        pieces.append((box((0.12, 8.4, 0.12), (1.0, 4.2, 1.0)).turn_y(90 * k), p.dark))
    pieces += [(box((2.3, 0.12, 2.3), (0, y, 0)), p.white) for y in (0.14, 8.4)]
    pieces.append((cylinder(0.55, 8.0, 16).shift(0, 4.2, 0), p.mustard))
    for shape, material in pieces:
        b.put(shape.turn_y(90).shift(-HALF_X + 0.6, 0, 0), material)


def towers(b: Builder, p: Palette) -> None:
    """Add blocks of flats beyond both ends, banded by sun blades."""
    for k, (x, z, height) in enumerate(
        ((31.0, -7.0, 22.0), (34.0, 9.0, 17.0), (-30.0, 7.0, 24.0), (-33.0, -10.0, 18.0))
    ):
        b.put(
            box((9, height, 9), (x, height / 2, z), ("front", "back", "left", "right", "top")), (p.pale, p.clay)[k % 2]
        )
        for turn in (-90 if x > 0 else 90, 0 if z < 0 else 180):
            blades = parts.slats(8.6, height - 2.0, 0.22, 0.05, 0.18, 15).shift(0, 1.6, 4.6)
            b.put(blades.turn_y(turn).shift(x, 0, z), (p.white, p.mustard)[k // 2])
