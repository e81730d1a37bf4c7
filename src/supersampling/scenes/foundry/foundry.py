"""The built-in scene ``foundry``: a hall of 24 x 14 x 8 m full of steel, brick, meshes and moving machines."""

import numpy as np

from supersampling.scenes.foundry.hall import lamps, markings, panels, pipes, shell, walkway
from supersampling.scenes.foundry.machines import machines
from supersampling.scenes.foundry.stock import Stock, stock
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import barrel, crate, fence
from supersampling.scenes.kit.routes import walk
from supersampling.scenes.kit.shapes import beam, box, cylinder, lathe
from supersampling.scenes.scene import Route, Scene, Sky, Sun


def _shelf(b: Builder, m: Stock, x: float, z: float, turn: float, seed: int) -> None:
    """Add a rack 2.6 m wide with three boards of boxes, drums and brass fittings; it looks along +z before the turn."""
    rng = np.random.default_rng(seed)
    parts = [(box((0.05, 2.5, 0.05), (u, 1.25, w)), m.red) for u in (-1.3, 0, 1.3) for w in (-0.35, 0.35)]
    parts += [(beam((-1.3 + s, 0.2, -0.36), (s, 2.4, -0.36), 0.025), m.iron) for s in (0.0, 1.3)]
    for y in (0.3, 1.05, 1.8):
        parts.append((box((2.7, 0.04, 0.8), (0, y, 0)), m.wood))
        u = -1.05
        while u < 1.1:
            size = float(rng.uniform(0.32, 0.55))
            if rng.random() < 0.8:
                thing = crate(size, int(rng.integers(16))).shift(u, y + 0.02 + size / 2, float(rng.uniform(-0.05, 0.1)))
                parts.append((thing, m.crates))
            else:
                profile = [(0, 0.3), (0.1, 0.3), (0.16, 0.22), (0.16, 0.18), (0.07, 0.14), (0.07, 0.06)]
                profile += [(0.18, 0.03), (0.18, 0)]
                parts.append((lathe(profile, 24).shift(u, y + 0.02, 0.05), m.brass))
            u += size + 0.07
    for shape, material in parts:
        b.put(shape.turn_y(turn).shift(x, 0, z), material)


def _stores(b: Builder, m: Stock) -> None:
    """Add shelves, pallets of crates, barrels."""
    for i, x in enumerate((-7.4, -4.4, -1.4, 1.6, 4.6, 7.6)):
        _shelf(b, m, x, 6.15, 180, i)
    for i, z in enumerate((0.4, 3.3)):
        _shelf(b, m, 11.55, z, -90, 20 + i)
    stack = ((-4.8, 0, 2.6), (-3.95, 0, 2.7), (-4.7, 1, 2.65), (-4.0, 0, 3.5), (-2.9, 0, 2.75), (-2.9, 1, 2.75))
    for i, (x, y, z) in enumerate(stack):
        size = (0.7, 0.62, 0.5)[i % 3]
        base = 0.14 if y == 0 else 0.14 + (0.7 if i == 2 else 0.62)
        b.put(crate(size, i * 3 + 1).turn_y(7 * (i % 3) - 6).shift(x, base + size / 2, z), m.crates)
    for z in (2.3, 2.65, 3.0, 3.35, 3.7):
        b.put(box((2.9, 0.03, 0.2), (-3.8, 0.125, z)), m.wood)
    for x in (-5.1, -3.8, -2.5):
        b.put(box((0.12, 0.11, 1.6), (x, 0.055, 3.0)), m.wood)
    drums = [(-11.2, 3.4), (-10.5, 3.5), (-10.9, 4.1), (-11.3, -3.6), (-10.6, -3.4)]
    drums += [(9.0, -6.3), (9.7, -6.2), (-6.2, -0.6), (-6.3, -1.4)]
    for i, (x, z) in enumerate(drums):
        b.put(barrel((x, 0, z)), (m.red, m.green, m.yellow)[i % 3])
    b.put(barrel((-10.9, 0.9, 3.6)), m.yellow)


def _fences(b: Builder, m: Stock) -> None:
    """Add low mesh fences along the lanes and a high one before the conveyor's end."""
    for a, c, height in (
        ((0.0, 0, -0.1), (3.0, 0, -0.1), 1.15),
        ((4.6, 0, -0.1), (9.0, 0, -0.1), 1.15),
        ((-5.6, 0, 0.0), (-2.2, 0, 0.0), 1.15),
        ((-6.6, 0, 2.2), (-6.6, 0, 4.0), 1.15),
        ((9.7, 0, 0.3), (9.7, 0, 3.2), 1.9),
    ):
        mesh, frame = fence(a, c, height)
        b.put(mesh, m.fence)
        b.put(frame, m.yellow)


def _rods(b: Builder, m: Stock) -> None:
    """Add bundles of steel rods on trestles in the middle of the hall."""
    for x in (4.9, 6.4, 7.9):
        b.put(beam((x, 0.5, -2.42), (x, 0.5, -1.68), 0.08), m.wood)
        for z in (-2.38, -1.72):
            b.put(beam((x, 0, z), (x, 1.0, z), 0.07), m.yellow)
    rng = np.random.default_rng(40)
    rod = cylinder(0.032, 3.9, 8).turn((0, 0, 1), 90)
    for row in range(5):
        for column in range(9):
            x, shift = 6.4 + float(rng.uniform(-0.25, 0.25)), 0.035 * (row % 2)
            place = rod.shift(x, 0.573 + 0.058 * row, -2.32 + 0.068 * column + shift)
            b.put(place, (m.steel, m.iron, m.brass)[int(rng.integers(3))])


def _routes() -> list[Route]:
    return [
        walk("gears", [(-8.0, 1.6, -3.3), (-1.2, 1.65, -3.1)], [(-7.2, 1.6, -6), (-3.0, 2.0, -6)]),
        walk("conveyor", [(-0.5, 1.6, 4.1), (9.2, 1.7, 4.0)], [(3.0, 0.9, 1.5), (5.5, 1.0, 1.0)]),
        walk(
            "furnace",
            [(-7.6, 1.65, 4.6), (-8.2, 1.6, 1.0), (-7.6, 1.6, -2.8)],
            [(-11, 1.4, 1.2), (-11, 1.5, 0), (-6, 1.6, -6)],
        ),
        walk("shelves", [(8.6, 1.6, 4.6), (-3.0, 1.6, 4.6)], [(5.5, 1.4, 6.3), (-6.5, 1.4, 6.3)]),
        walk("press", [(0.0, 1.65, -2.7), (9.6, 1.65, -3.3)], [(3.6, 1.7, -5.5), (11.0, 2.5, -4.2)]),
        walk("east aisle", [(10.3, 1.65, 4.4), (10.35, 1.6, -3.6)], [(5.0, 1.2, 1.8), (4.6, 1.8, -5.0)]),
        walk("crane", [(9.8, 1.7, -0.9), (3.2, 1.6, -1.1)], [(3.0, 1.8, -0.6), (-3.2, 1.5, -1.0)]),
        walk(
            "winding gear",
            [(-7.2, 1.6, 0.9), (-1.4, 1.6, 1.2), (-1.0, 1.6, 3.2)],
            [(-3.6, 1.3, -0.8), (-1.0, 1.2, -1.0), (4, 1.0, 1.6)],
        ),
    ]


def foundry() -> Scene:
    """Build an industrial hall: wheels, fans, a press, a crane, a conveyor and a furnace, all moving periodically."""
    builder = Builder()
    m = stock(builder)
    for part in (shell, markings, walkway, pipes, panels, _stores, _fences, _rods, machines):
        part(builder, m)
    lights = lamps(builder, m)
    meshes, objects = builder.build()
    return Scene(
        name="foundry",
        materials=builder.materials,
        meshes=meshes,
        objects=objects,
        routes=_routes(),
        sun=Sun((0.35, 0.85, 0.3), (4.4, 4.0, 3.4)),
        points=lights,
        sky=Sky(ambient=0.7),
        exposure=1.0,
        near=0.1,
        far=60.0,
        attribution="Geometry, textures and lettering are generated by this project's code (MIT); "
        "text is set in DejaVu fonts.",
    )
