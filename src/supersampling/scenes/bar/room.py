"""The bar's room: walls, floor and ceiling, the counter with its canopy, and the shelves of bottles behind it."""

import numpy as np

from supersampling.scenes.bar import parts
from supersampling.scenes.bar import shapes as forms
from supersampling.scenes.bar.materials import Palette
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.shapes import box, cylinder, lathe, panel, quad, sphere, tube

HALF_X, HALF_Z, HEIGHT = 8.0, 5.0, 3.6
COUNTER = forms.rounded([(-6.4, -4.98), (-6.4, -2.5), (4.0, -2.5), (4.0, -4.98)], 1.1)
PENDANTS = (-4.6, -2.4, -0.2, 2.0)  # x of the lamps over the counter, at z = PENDANT_Z
PENDANT_Z, PENDANT_Y = -2.75, 2.2
BAYS = (-4.2, -1.2, 1.8)  # middles of the shelves' three bays, 2.8 m wide
_SHELVES = (1.32, 1.76, 2.2)


def shell(b: Builder, p: Palette) -> None:
    """Add a floor, ceiling with beams, walls with wainscot, the window."""
    b.put(panel((-HALF_X, 0, -HALF_Z), (16, 0, 0), (0, 0, 10)), p.floor)
    b.put(panel((-HALF_X, HEIGHT, HALF_Z), (16, 0, 0), (0, 0, -10)), p.ceiling)
    for x in (-6.4, -3.2, 0.0, 3.2, 6.4):
        b.put(box((0.2, 0.2, 10), (x, HEIGHT - 0.1, 0), ("left", "right", "bottom")), p.wood)
        for side in (-0.1, 0.1):
            b.put(box((0.012, 0.02, 10), (x + side, HEIGHT - 0.19, 0)), p.brass)
    ends = [(-HALF_X, -HALF_Z), (HALF_X, -HALF_Z), (HALF_X, HALF_Z), (-HALF_X, HALF_Z)]
    for k in range(4):
        a, c = np.array(ends[k]), np.array(ends[(k + 1) % 4])
        line = np.linspace(a, c, 3)
        b.put(forms.sweep(line, [(0.14, 3.6), (0.12, 3.52), (0.05, 3.42), (0.0, 3.4)]), p.wood)
        b.put(forms.sweep(line, [(0.0, 3.4), (0.0, 1.14)]), p.paper)
        b.put(
            forms.sweep(
                line,
                [
                    (0.0, 1.14),
                    (0.055, 1.14),
                    (0.06, 1.08),
                    (0.03, 1.04),
                    (0.02, 1.03),
                    (0.02, 0.18),
                    (0.04, 0.15),
                    (0.045, 0.0),
                ],
            ),
            p.wood,
        )
        b.put(forms.sweep(line, [(0.0, 1.17), (0.016, 1.165), (0.016, 1.15), (0.0, 1.14)]), p.brass)
        count = round(float(np.abs(c - a).sum()) / 1.0)
        for share in (np.arange(count) + 0.5) / count:
            x, z = a + share * (c - a)
            plaque = box((0.74, 0.62, 0.02), (0, 0.6, 0.03), ("front", "top", "left", "right"))
            b.put(plaque.turn_y(-90 * k).shift(x, 0, z), p.wood)
    _window(b, p)


def _window(b: Builder, p: Palette) -> None:
    """Add the town behind the west wall's window, in panes."""
    b.put(quad((-7.98, 3.1, 3.6), (0, 0, -7.2), (0, -1.9, 0)), p.town)
    for z in np.linspace(-3.6, 3.6, 7):
        b.put(box((0.1, 1.98, 0.07), (-7.95, 2.15, z), ("right", "front", "back")), p.wood)
    for y, tall in ((1.2, 0.1), (2.5, 0.05), (3.12, 0.1)):
        b.put(box((0.12, tall, 7.3), (-7.94, y, 0), ("right", "top", "bottom", "front", "back")), p.wood)
    b.put(box((0.26, 0.03, 7.4), (-7.87, 1.255, 0)), p.top)


def counter(b: Builder, p: Palette) -> None:
    """Add the counter, its foot rail, taps, glasses, stools, and the canopy with the lamps."""
    b.put(
        forms.sweep(
            COUNTER,
            [(-0.66, 1.07), (-0.66, 1.12), (0.17, 1.12), (0.2, 1.105), (0.2, 1.085), (0.17, 1.07), (-0.02, 1.07)],
        ),
        p.top,
    )
    b.put(forms.sweep(COUNTER, [(0.0, 1.07), (0.05, 1.03), (0.07, 0.98), (0.04, 0.94), (0.02, 0.92)]), p.wood)
    b.put(forms.sweep(COUNTER, [(0.02, 0.92), (0.02, 0.32)]), p.red)
    b.put(forms.sweep(COUNTER, [(0.02, 0.32), (0.05, 0.3), (0.05, 0.12), (0.08, 0.1), (0.08, 0.0)]), p.wood)
    b.put(forms.sweep(COUNTER, [(-0.6, 0.0), (-0.6, 1.07)]), p.wood)
    for y in (0.93, 0.31):
        b.put(forms.sweep(COUNTER, [(0.02, y + 0.015), (0.04, y + 0.01), (0.04, y - 0.01), (0.02, y - 0.015)]), p.brass)
    b.put(forms.sweep(COUNTER, [(0.195, 1.108), (0.212, 1.104), (0.212, 1.086), (0.195, 1.082)]), p.brass)
    rail = forms.rounded([(-6.65, -4.95), (-6.65, -2.25), (4.25, -2.25), (4.25, -4.95)], 1.1)
    b.put(tube(np.stack([rail[:, 0], 0 * rail[:, 0] + 0.18, rail[:, 1]], 1), 0.026, 12), p.brass)
    for x in np.arange(-5.2, 3.0, 1.15):
        b.put(box((0.03, 0.02, 0.25), (x, 0.18, -2.36)), p.brass)
        b.put(cylinder(0.014, 0.18, 10).shift(x, 0.09, -2.25), p.brass)
        b.put(box((0.09, 0.62, 0.05), (x, 0.62, -2.465)), p.wood)
    metal, handles = parts.taps(5)
    for x, tint in ((-3.4, p.ruby), (0.9, p.cream)):
        b.put(metal.shift(x, 1.12, -2.8), p.brass)
        b.put(handles.shift(x, 1.12, -2.8), tint)
    chrome, brass, seat = parts.stool()
    for k, x in enumerate(np.arange(-5.0, 3.3, 1.0)):
        for shape, material in ((chrome, p.chrome), (brass, p.brass), (seat, p.red)):
            b.put(shape.turn_y(37 * k).shift(x + 0.06 * (k % 3), 0, -1.72 + 0.05 * (k % 2)), material)
    _canopy(b, p)


def _canopy(b: Builder, p: Palette) -> None:
    """Add a soffit over the counter with a line of neon, glasses that hang from it, and four lamps."""
    b.put(
        forms.sweep(
            COUNTER,
            [(-0.5, 2.8), (-0.5, 3.08), (0.0, 3.08), (0.05, 3.05), (0.05, 2.85), (0.0, 2.82), (0.0, 2.8), (-0.5, 2.8)],
        ),
        p.wood,
    )
    for y in (3.04, 2.86):
        b.put(
            forms.sweep(COUNTER, [(0.05, y + 0.012), (0.062, y + 0.008), (0.062, y - 0.008), (0.05, y - 0.012)]),
            p.brass,
        )
    line = forms.rounded([(-6.48, -4.9), (-6.48, -2.42), (4.08, -2.42), (4.08, -4.9)], 1.1)
    b.put(tube(np.stack([line[:, 0], 0 * line[:, 0] + 2.82, line[:, 1]], 1), 0.018, 6), p.neon["pink"])
    for x in np.arange(-5.0, 3.1, 2.0):
        b.put(cylinder(0.012, 0.55, 8).shift(x, 3.33, -2.7), p.brass)
    shade, inside, bulb = parts.pendant(2.8 - PENDANT_Y)
    for x in PENDANTS:
        for shape, material in ((shade, p.copper), (inside, p.cream), (bulb, p.bulb)):
            b.put(shape.shift(x, 2.8, PENDANT_Z), material)
    for x in (-3.9, -3.1, -1.7, -0.9, 0.5, 1.3):
        for dz in (-0.08, -0.02):
            b.put(box((0.5, 0.008, 0.012), (x, 2.775, -2.82 + dz)), p.brass)
        for dx in (-0.12, 0.05):
            glass = parts.drinking_glass(2)
            hanging_glass = glass.transform(np.diag([1.0, -1.0, -1.0, 1.0])).shift(x + dx, 2.77, -2.87)
            b.put(hanging_glass, p.dark_glass)


def shelves(b: Builder, p: Palette, rng: np.random.Generator) -> None:
    """Add a cabinet, tiled wall and lit onyx, three bays of three shelves with bottles."""
    b.put(box((9.2, 0.9, 0.48), (-1.2, 0.45, -4.74), ("front", "left", "right")), p.wood)
    b.put(box((9.3, 0.045, 0.54), (-1.2, 0.922, -4.72)), p.top)
    for x in np.arange(-5.4, 3.1, 0.7):
        b.put(box((0.6, 0.7, 0.02), (x, 0.46, -4.49)), p.wood)
        b.put(sphere(0.018, 8).shift(x + 0.24, 0.5, -4.46), p.brass)
    for k, x in enumerate(BAYS):
        b.put(panel((x - 1.4, 2.9, -4.97), (2.8, 0, 0), (0, -1.96, 0)), p.onyx if k == 1 else p.tiles)
        for y in _SHELVES:
            b.put(box((2.74, 0.03, 0.26), (x, y - 0.015, -4.84)), p.wood)
            b.put(box((2.74, 0.012, 0.012), (x, y - 0.012, -4.706)), p.brass)
            b.put(box((2.7, 0.012, 0.02), (x, y - 0.037, -4.93)), p.strip)
            _bottles(b, p, rng, x, y)
    for x in (-5.65, -2.7, 0.3, 3.25):
        b.put(box((0.16, 2.0, 0.34), (x, 1.94, -4.83)), p.wood)
        b.put(
            lathe([(0.09, 2.9), (0.05, 2.84), (0.045, 1.1), (0.08, 1.0), (0.09, 0.945)], 20).shift(x, 0, -4.6), p.brass
        )
    b.put(box((9.2, 0.22, 0.5), (-1.2, 3.02, -4.75)), p.wood)
    b.put(box((9.26, 0.03, 0.54), (-1.2, 2.91, -4.73)), p.brass)
    b.put(quad((-2.1, 3.12, -4.49), (1.8, 0, 0), (0, -0.2, 0)), p.signs[2])
    _worktop(b, p, rng)


def _bottles(b: Builder, p: Palette, rng: np.random.Generator, x: float, y: float) -> None:
    """Add a shelf of bottles in small groups of one kind, with a few smoked ones between."""
    u = -1.26
    while u < 1.25:
        kind, tint = int(rng.integers(5)), int(rng.integers(5))
        for _ in range(int(rng.integers(1, 4))):
            glass, label = parts.bottle(kind, 3 * kind + tint)
            place = (x + u, y, -4.84 + float(rng.uniform(-0.03, 0.05)))
            turn = float(rng.uniform(-40, 40))
            b.put(glass.turn_y(turn).shift(*place), p.glass[tint])
            if label is not None:
                b.put(label.turn_y(turn).shift(*place), p.labels)
            u += 0.15
            if u > 1.25:
                break
        u += 0.04


def _worktop(b: Builder, p: Palette, rng: np.random.Generator) -> None:
    """Add shakers, mugs, glasses and bottles on the counter and on the cabinet."""
    shaker = lathe(
        [(0, 0.24), (0.02, 0.24), (0.022, 0.21), (0.034, 0.18), (0.036, 0.15), (0.044, 0.14), (0.036, 0), (0, 0)], 14
    )
    mug = lathe([(0.001, 0.01), (0.036, 0.015), (0.04, 0.1), (0.043, 0.1), (0.04, 0)], 14)
    bowl = lathe([(0.001, 0.03), (0.12, 0.09), (0.125, 0.09), (0.06, 0.01), (0.05, 0)], 18)
    for x in np.arange(-5.0, 3.2, 0.62):
        place = (x + float(rng.uniform(-0.15, 0.15)), 1.12, -2.62 + float(rng.uniform(-0.12, 0.16)))
        if min(abs(place[0] + 3.4), abs(place[0] - 0.9)) > 0.5:
            kind = int(rng.integers(3))
            b.put(parts.drinking_glass(kind).shift(*place), p.dark_glass if kind else p.glass[4])
            b.put(mug.shift(place[0] + 0.14, 1.12, place[2] - 0.12), p.copper)
    for x in (-5.2, -4.6, -2.3, -0.6, 0.1, 2.4):
        b.put(shaker.shift(x, 0.945, -4.62), p.chrome)
        b.put(bowl.shift(x + 0.26, 0.945, -4.68), p.brass if x < -1 else p.copper)
    for x in (-4.9, -1.9, 1.9):
        b.put(shaker.shift(x, 1.12, -2.95), p.chrome)
        glass, label = parts.bottle(1, 7)
        b.put(glass.shift(x + 0.16, 1.12, -2.96), p.glass[1])
        if label is not None:
            b.put(label.shift(x + 0.16, 1.12, -2.96), p.labels)
