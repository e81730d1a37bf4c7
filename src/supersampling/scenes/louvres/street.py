"""Furniture of the louvred street: pergola, tables, deck chairs, planters, screens, and everything that moves."""

import numpy as np

from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.motion import spin, sway
from supersampling.scenes.kit.shapes import beam, box, cylinder, lathe, panel
from supersampling.scenes.louvres import parts
from supersampling.scenes.louvres.materials import Palette

PERGOLA = (4.0, 12.0, 1.7)  # from x to x, half its depth
CAGE = (-4.6, 0.0)
SCREENS = ((-9.2, -0.9), (-9.2, 0.9))


def pergola(b: Builder, p: Palette) -> None:
    """Add a roof of slats on posts, with seats beneath; the slats stripe the ground with shadow."""
    left, right, half = PERGOLA
    for x in (left, (left + right) / 2, right):
        for z in (-half, half):
            b.put(box((0.12, 2.9, 0.12), (x, 1.45, z)), p.white)
            b.put(box((0.2, 0.1, 0.2), (x, 0.05, z)), p.band)
    for z in (-half, half):
        b.put(box((right - left + 0.6, 0.18, 0.08), ((left + right) / 2, 2.9, z)), p.white)
    roof = parts.roof_slats(right - left + 0.5, 2 * half + 0.6, 0.075)
    b.put(roof.shift((left + right) / 2, 2.99, 0), p.ash)
    for k, x in enumerate((5.2, 7.0, 9.0, 10.8)):
        z = (-0.95, 0.95)[k % 2]
        b.put(box((0.8, 0.04, 0.8), (x, 0.74, z)), p.white)
        b.put(box((0.82, 0.2, 0.82), (x, 0.67, z), ("front", "back", "left", "right")), (p.gingham, p.check)[k // 2])
        b.put(panel((x - 0.41, 0.765, z - 0.41), (0.82, 0, 0), (0, 0, 0.82)), (p.gingham, p.check)[k // 2])
        b.put(lathe([(0.03, 0.72), (0.03, 0.05), (0.24, 0.03), (0.25, 0)], 16).shift(x, 0, z), p.dark)
        seat, feet = parts.bench(1.2)
        for dz in (-0.75, 0.75):
            turn = 0 if dz < 0 else 180
            if abs(z + dz) > 0.8:
                b.put(seat.turn_y(turn).shift(x, 0, z + dz), p.ash)
                b.put(feet.turn_y(turn).shift(x, 0, z + dz), p.dark)


def furniture(b: Builder, p: Palette) -> None:
    """Add deck chairs, benches, planters, bicycle racks and tables with cloths along both sides."""
    cloth, wood = parts.deck_chair()
    for k, (x, z) in enumerate(((-7.2, -1.0), (-7.0, 0.9), (-2.4, 1.3), (-2.2, -1.2), (1.9, 1.1), (2.0, -1.0))):
        turn = 90 + 17 * (k % 3) if x < -4 else -70 - 15 * (k % 3)
        b.put(cloth.turn_y(turn).shift(x, 0, z), p.deck[k % 2])
        b.put(wood.turn_y(turn).shift(x, 0, z), p.ash)
    box_tree, ball = parts.planter(0.7)
    for k, x in enumerate(np.arange(9) * 4.0 - 16.0):
        for z in (-5.4, 5.4):
            if abs(x) < 15:
                b.put(box_tree.shift(float(x), 0, z), (p.cedar, p.white)[k % 2])
                b.put(ball.turn_y(40.0 * k).shift(float(x), 0, z), p.hedge)
    seat, feet = parts.bench(1.8)
    for x in (-10.0, -2.0, 6.0):
        for z, turn in ((-5.5, 0), (5.6, 180)):
            b.put(seat.turn_y(turn).shift(x, 0, z), (p.cedar, p.ash)[turn > 0])
            b.put(feet.turn_y(turn).shift(x, 0, z), p.dark)
    for x, z in ((-13.6, -0.6), (13.7, 0.4)):
        rack = parts.rods(2.0, 0.8, 0.1, 0.012).turn_y(90).shift(x, 0, z)
        b.put(rack, p.dark)
        b.put(beam((x, 0.8, z - 1.05), (x, 0.8, z + 1.05), 0.04), p.dark)
    top, pole = parts.parasol(1.15, 2.7)
    for k, (x, z) in enumerate(((-6.4, 4.75), (9.6, 4.75))):
        b.put(pole.shift(x, 0, z), p.white)
        b.put(top.shift(x, 0, z), p.awnings[k])
        b.put(lathe([(0, 0.72), (0.4, 0.72), (0.4, 0.52)], 20).shift(x, 0, z), p.gingham)


def screens(b: Builder, p: Palette) -> None:
    """Add free-standing frames in which blinds hang."""
    for x, z in SCREENS:
        for dz in (-0.75, 0.75):
            b.put(box((0.08, 2.5, 0.08), (x, 1.25, z + dz)), p.white)
        b.put(box((0.1, 0.1, 1.66), (x, 2.52, z)), p.white)


def movers(b: Builder, p: Palette) -> None:
    """Add two cages of rods that turn against each other, and blinds and a parasol that sway."""
    x, z = CAGE
    b.put(cylinder(1.35, 0.16, 36).shift(x, 0.08, z), p.pale)
    b.put(cylinder(0.03, 2.9, 10).shift(x, 1.55, z), p.dark)
    spokes = [
        beam((0, y, 0), (1.05 * np.cos(a), y, 1.05 * np.sin(a)), 0.02)
        for y in (0.0, 2.6)
        for a in np.arange(6) * np.pi / 3
    ]
    outer = parts.cage(1.05, 2.6, 110, 0.009)
    b.move([(outer, p.white), *((s, p.white) for s in spokes)], spin((x, 0.26, z), (0, 1, 0), 0.012))
    inner = [
        beam((0, y, 0), (0.78 * np.cos(a), y, 0.78 * np.sin(a)), 0.02)
        for y in (0.0, 2.4)
        for a in np.arange(4) * np.pi / 2
    ]
    b.move(
        [(parts.cage(0.78, 2.4, 90, 0.009), p.rust), *((s, p.rust) for s in inner)],
        spin((x, 0.36, z), (0, 1, 0), -0.018, 0.2),
    )
    blind, cords = parts.hanging_blind(1.36, 2.0, 0.042)
    for k, (u, v) in enumerate(SCREENS):
        motion = sway((u, 2.45, v), (0, 0, 1), 2.5, 0.17 + 0.03 * k, 1.7 * k)
        b.move([(blind.turn_y(90), (p.blue, p.mustard)[k]), (cords.turn_y(90), p.white)], motion)
    left, right, half = PERGOLA
    wide, lines = parts.hanging_blind(2.6, 1.0, 0.042)
    for k, u in enumerate((left + 2.0, right - 2.0)):
        for side in (-1, 1):
            motion = sway((u, 2.8, side * (half + 0.02)), (1, 0, 0), 2.2, 0.2 + 0.02 * k, 0.9 * k + side)
            b.move([(wide, p.white), (lines, p.ash)], motion)
    top, pole = parts.parasol(1.1, 2.6)
    b.move([(top, p.awnings[2]), (pole, p.white)], sway((3.9, 0.0, -4.5), (1, 0, 0.4), 1.2, 0.21, 0.5))
