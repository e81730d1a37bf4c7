"""The built-in scene ``atrium``: the courtyard of a library, between two colonnades, open to the sky."""

import numpy as np

from supersampling.scenes.atrium import parts
from supersampling.scenes.atrium.materials import Palette
from supersampling.scenes.atrium.motion import movers
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import bookcase, framed_picture
from supersampling.scenes.kit.routes import walk
from supersampling.scenes.kit.shapes import atlas_cell, box, cylinder, lathe, panel, quad, tube
from supersampling.scenes.scene import PointLight, Route, Scene, Sky, Sun

LENGTH, WIDTH, HEIGHT = 22.0, 16.0, 7.0
ROW, TOP = 4.5, 5.1  # the columns stand at z = +-ROW; the arches' wall ends at TOP
COLUMNS = np.arange(8) * parts.BAY - 9.8
BAYS = COLUMNS[:-1] + parts.BAY / 2
LANTERNS = ((-8.4, 6.2), (0.0, -6.2), (8.4, 6.2))


def _shell(b: Builder, p: Palette) -> None:
    """Add floors, walls, ceilings and roofs."""
    b.put(panel((-11, 0, -ROW), (LENGTH, 0, 0), (0, 0, 2 * ROW), (9, 22)), p.tiles)
    for side, turn in ((-1, 0), (1, 180)):
        b.put(panel((-11, 0, -8), (LENGTH, 0, 0), (0, 0, 3.5), (4, 22)).turn_y(turn), p.cobbles)
        b.put(panel((-11, 7, -8), (LENGTH, 0, 0), (0, -6.1, 0), (4, 16)).turn_y(turn), p.brick)
        b.put(box((LENGTH, 0.9, 0.1), (0, 0.45, -7.95), ("front", "top")).turn_y(turn), p.ashlar)
        b.put(panel((-11, 5.6, -4.3), (LENGTH, 0, 0), (0, 0, -3.7), (4, 16)).turn_y(turn), p.oak)
        rafter = box((0.16, 0.2, 3.5), (0, 5.5, -6.2), ("front", "left", "right", "bottom"))
        for x in np.arange(-10.5, 11, 1.0):
            b.put(rafter.shift(x, 0, 0).turn_y(turn), p.oak)
        b.put(panel((-11, 7.0, -8), (LENGTH, 0, 0), (0, -1.1, 3.8), (3, 22)).turn_y(turn), p.roof)
        b.put(box((LENGTH, 0.5, 0.5), (0, TOP + 0.25, -ROW), ("front", "back", "bottom", "top")).turn_y(turn), p.ashlar)
        b.put(box((LENGTH, 0.3, 0.8), (0, TOP + 0.65, -ROW), ("front", "back", "bottom", "top")).turn_y(turn), p.column)
        dentil = box((0.14, 0.12, 0.14), (0, TOP + 0.44, -ROW + 0.3))
        for x in np.arange(-10.85, 11, 0.3):
            b.put(dentil.shift(x, 0, 0).turn_y(turn), p.column)
        for k, x in enumerate((-7.0, -2.334, 2.333, 7.0)):
            band = quad((x - 2.2, TOP + 0.4, -ROW + 0.262), (4.4, 0, 0), (0, -0.4, 0), (1, 4))
            b.put(band.turn_y(turn), p.friezes[(k + (side > 0)) % 2])
    for turn in (90, -90):
        b.put(panel((-8, 7, -11), (WIDTH, 0, 0), (0, -6.1, 0), (4, 16)).turn_y(turn), p.brick)
        b.put(box((WIDTH, 0.9, 0.1), (0, 0.45, -10.95), ("front", "top")).turn_y(turn), p.ashlar)
        b.put(box((WIDTH, 0.3, 0.3), (0, 5.4, -10.85), ("front", "top", "bottom")).turn_y(turn), p.column)
        b.put(box((WIDTH, 0.25, 0.4), (0, 6.95, -10.9)).turn_y(turn), p.column)
    for k, (x, z) in enumerate(((-5.5, -3.2), (5.5, -3.2), (-5.5, 1.7), (5.5, 1.7))):
        slab = box((4.0, 0.024, 0.5), (x, 0.012, z), ("front", "back", "left", "right"))
        b.put(slab, p.column)
        b.put(quad((x - 2, 0.024, z - 0.25), (4, 0, 0), (0, 0, 0.5), (1, 4)), p.pavings[k % 2])


def _colonnades(b: Builder, p: Palette) -> None:
    """Add columns, arches, railings and lattice screens; the bays at x = 0 and +-8.4 stay open."""
    shaft, mouldings, square = parts.column()
    wall, ring = parts.arch(TOP - parts.SPRING)
    for z in (-ROW, ROW):
        for k, x in enumerate(COLUMNS):
            tint = 0.92 + 0.08 * ((k * 5 + (z > 0)) % 3)
            b.put(shaft.turn_y(18 * k).shift(x, 0, z), p.shaft, (tint, tint, 0.98 * tint))
            b.put(mouldings.turn_y(18 * k).shift(x, 0, z), p.column)
            b.put(square.shift(x, 0, z), p.ashlar)
        for x in BAYS:
            b.put(wall.shift(x, 0, z), p.brick)
            b.put(ring.shift(x, 0, z), p.column)
        for x in (-10.6, 10.6):
            b.put(box((0.8, TOP, 0.5), (x, TOP / 2, z), ("front", "back", "left", "right")), p.ashlar)
        for x in (-5.6, 5.6):
            b.put(parts.railing(1.95).shift(x, 0, z), p.iron)
        lattice, frame = parts.screen(1.9, 2.3)
        for x, weave in ((-2.8, p.lattice), (2.8, p.mesh)):
            b.put(lattice.shift(x, 0, z), weave)
            b.put(frame.shift(x, 0, z), p.oak)


def _walls(b: Builder, p: Palette, rng: np.random.Generator) -> None:
    """Add bookcases, newspapers, posters and rules on the four walls, and the clock's face."""
    cases = [bookcase(rng) for _ in range(2)]
    picture, frame = framed_picture(1.5, 1.5)
    poster, poster_frame = framed_picture(1.0, 1.0)
    for turn in (0, 180):
        for k, x in enumerate(BAYS):
            if k % 2 == 0:
                wood, books = cases[k // 2 % 2]
                b.put(wood.shift(x, 0, -7.9).turn_y(turn), p.oak)
                b.put(books.map_uv((1, 1), (k * 3 / 16, k / 4)).shift(x, 0, -7.9).turn_y(turn), p.spines)
                b.put(poster.shift(x, 3.9, -7.97).turn_y(turn), p.posters[(k // 2 + turn // 90) % 4])
                b.put(poster_frame.shift(x, 3.9, -7.97).turn_y(turn), p.oak)
            else:
                sheet = p.papers[(k // 2 + turn // 180) % 4]
                for y, material in ((2.0, sheet), (3.8, p.papers[(k // 2 + 2) % 4])):
                    b.put(picture.shift(x, y, -7.97).turn_y(turn), material)
                    b.put(frame.shift(x, y, -7.97).turn_y(turn), p.oak)
    for turn in (90, -90):
        for k, x in enumerate((-6.4, -3.2, -1.6, 1.6, 3.2, 6.4)):
            small = k in (0, 5)
            material = p.notice if k == 4 else p.posters[(k + turn // 90) % 4] if k % 2 else p.papers[k // 2]
            b.put((poster if small else picture).shift(x, 2.0, -10.97).turn_y(turn), material)
            b.put((poster_frame if small else frame).shift(x, 2.0, -10.97).turn_y(turn), p.oak)
    for x in (-2.6, 2.6):
        b.put(picture.shift(x, 4.0, -10.97).turn_y(90), p.papers[3])
        b.put(frame.shift(x, 4.0, -10.97).turn_y(90), p.oak)
    for turn in (90, -90):
        b.put(quad((-0.8, 0.8, 0), (1.6, 0, 0), (0, -1.6, 0)).shift(0, 3.9, -10.9).turn_y(turn), p.clock)
        b.put(box((1.8, 1.8, 0.09), (0, 3.9, -10.95)).turn_y(turn), p.oak)


def _furniture(b: Builder, p: Palette, rng: np.random.Generator) -> None:
    """Add plants, benches, crates, cables, lanterns' rods, the statue's pedestal and the cart's rails."""
    spots = [(x, -3.72) for x in (-7.0, -1.4, 1.4, 7.0)] + [(x, z) for x in (-10.3, 10.3) for z in (-7.3, 7.3)]
    spots += [(-10.2, -2.4), (-10.2, 2.4), (10.2, -2.4), (10.2, 2.4)]
    for k, (x, z) in enumerate(spots):
        pot, soil, cards = parts.plant(rng, 1.0 + 0.1 * (k % 5))
        for shape, material in ((pot, p.clay), (soil, p.soil), (cards, p.leaves[k % 2])):
            b.put(shape.shift(x, 0, z), material)
    feet, slats = parts.bench()
    for x, z, turn in ((-3.0, -1.2, 0), (3.0, -1.2, 0), (-10.3, 0.0, 90), (10.3, 0.0, -90)):
        b.put(feet.turn_y(turn).shift(x, 0, z), p.ashlar)
        b.put(slats.turn_y(turn).shift(x, 0, z), p.oak)
    for k, (x, z, y) in enumerate(
        ((-9.9, 3.5, 0), (-9.85, 3.52, 0.6), (9.9, -3.5, 0), (9.9, -3.55, 0.6), (9.3, 3.6, 0))
    ):
        crate = box((0.6, 0.6, 0.6), (0, 0.3, 0), fit=True)
        b.put(crate.map_uv(*atlas_cell(4, 4, 3 * k)).turn_y(11 * k).shift(x, y, z), p.crates)
    for x in (-7.0, -4.2, 4.2, 7.0):
        b.put(tube(parts.sagging((x, 4.86, -4.3), (x, 4.86, 4.3), 0.0), 0.012, 5), p.iron)
    for z in (-1.0, 1.0):
        b.put(tube(parts.sagging((-10.9, 5.4, z), (10.9, 5.4, z), 0.5), 0.012, 5), p.iron)
    steps = [box((2.0, 0.16, 2.0), (0, 0.08, 0)), box((1.6, 0.16, 1.6), (0, 0.24, 0))]
    for shape in (
        *steps,
        box((1.0, 0.12, 1.0), (0, 1.26, 0)),
        lathe([(0.14, 1.62), (0.2, 1.55), (0.12, 1.45), (0.3, 1.32)], 24),
    ):
        b.put(shape, p.column)
    b.put(box((0.9, 0.9, 0.9), (0, 0.77, 0), ("front", "back", "left", "right"), True), p.notice)
    for z in (2.62, 3.18):
        b.put(box((17.0, 0.02, 0.05), (0, 0.01, z)), p.brass)
    for x in (-5.8, 5.8):
        b.put(cylinder(0.56, 0.25, 24).shift(x, 0.125, 0), p.column)


def _routes() -> list[Route]:
    """Return two walks in each aisle, three in the court, one across both rows of columns."""
    return [
        walk("north aisle to the statue", [(-9, 1.65, -6.2), (5, 1.65, -6.2)], [(-5, 1.5, 0), (8, 1.6, 1)]),
        walk("north shelves", [(8.6, 1.6, -5.7), (-4, 1.6, -5.9)], [(5, 1.6, -8), (-7.6, 1.6, -8)]),
        walk("south aisle to the statue", [(-9, 1.7, 6.2), (6, 1.7, 6.2)], [(-4, 1.6, 0), (8, 1.8, -1)]),
        walk("south papers", [(8.8, 1.6, 5.7), (-4, 1.6, 5.8)], [(5, 1.9, 8), (-7.8, 1.9, 8)]),
        walk("court past the plants", [(-8.5, 1.75, -2.5), (4.5, 1.75, -2.5)], [(-4, 1.9, 5), (8, 2.0, 5)]),
        walk(
            "court by the statue",
            [(8.6, 1.6, 1.7), (0, 1.6, 1.75), (-4, 1.6, 1.6)],
            [(3, 1.9, -5), (-4, 1.9, -7), (-9, 1.9, -5)],
        ),
        walk("west end", [(-8.4, 1.7, 3.4), (-8.3, 1.7, -6.2)], [(0, 1.8, 2), (0, 2.0, -5)]),
        walk("across at the east", [(8.4, 1.65, 6.6), (8.4, 1.65, -6.4)], [(0, 1.7, 4), (0, 1.8, -8)]),
    ]


def atrium() -> Scene:
    """Build the courtyard of a library, 22 x 16 x 7 m: fine print, thin iron and leaves, moving things, occlusions."""
    b, rng = Builder(), np.random.default_rng(7)
    p = Palette(b)
    _shell(b, p)
    _colonnades(b, p)
    _walls(b, p, rng)
    _furniture(b, p, rng)
    cage, glass = parts.lantern()
    for x, z in LANTERNS[:2]:
        b.put(cage.shift(x, 4.6, z), p.iron)
        b.put(glass.shift(x, 4.6, z), p.glow)
    for x, z in LANTERNS:
        b.put(cylinder(0.015, 1.1, 6).shift(x, 5.1, z), p.iron)
    movers(b, p)
    meshes, objects = b.build()
    return Scene(
        "atrium",
        b.materials,
        meshes,
        objects,
        _routes(),
        sun=Sun((0.4, 0.75, 0.32), (3.4, 3.1, 2.6)),
        points=[PointLight((x, 2.95, z), (7.0, 5.0, 2.8), 9.0) for x, z in LANTERNS],
        sky=Sky(ambient=1.0),
        exposure=0.75,
        near=0.1,
        far=80.0,
        attribution="Code and text: MIT. Gravel: scikit-image's photograph, CC0. Letters: DejaVu fonts, "
        "Bitstream Vera licence.",
    )
