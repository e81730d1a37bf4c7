"""The built-in scene ``turntable``: a carved machine turns slowly in a studio; every camera stands still."""

import numpy as np

from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import bookcase, framed_picture
from supersampling.scenes.kit.motion import spin
from supersampling.scenes.kit.routes import tripod
from supersampling.scenes.kit.shapes import beam, box, cylinder, lathe, panel, quad, tube
from supersampling.scenes.scene import PointLight, Route, Scene, Sky
from supersampling.scenes.turntable.materials import Materials
from supersampling.scenes.turntable.object import machine

HALF, HEIGHT = 4.0, 3.4
TABLE = 0.55  # height of the turntable's top
HERTZ = 1 / 24
LAMPS = (
    ((-2.3, 2.65, 2.7), (15.0, 12.6, 9.4)),
    ((2.9, 2.3, 1.7), (4.2, 5.2, 6.8)),
    ((0.6, 3.0, -2.9), (7.5, 6.4, 5.0)),
)


def _room(b: Builder, m: Materials) -> None:
    """Add a floor, walls with a wainscot, ceiling with beams."""
    side = 2 * HALF
    b.put(panel((-HALF, 0, -HALF), (side, 0, 0), (0, 0, side), (8, 8)), m.tiles)
    b.put(panel((-HALF, HEIGHT, HALF), (side, 0, 0), (0, 0, -side), (4, 4)), m.oak, (0.8, 0.8, 0.8))
    for k, turn in enumerate((0, 90, 180, 270)):
        wall = panel((-HALF, HEIGHT, -HALF), (side, 0, 0), (0, -HEIGHT, 0), (3, 6))
        b.put(wall.turn_y(turn), (m.plaster, m.brick)[k % 2])
        for y, tall, deep in ((0.1, 0.2, 0.06), (0.95, 0.06, 0.07), (HEIGHT - 0.08, 0.16, 0.12)):
            b.put(box((side, tall, deep), (0, y, -HALF + deep / 2)).turn_y(turn), m.oak)
        for x in np.arange(-HALF + 0.5, HALF, 0.5):
            b.put(box((0.06, 0.72, 0.04), (x, 0.56, -HALF + 0.02)).turn_y(turn), m.oak)
        b.put(box((side, 0.74, 0.02), (0, 0.57, -HALF + 0.01), ("front",)).turn_y(turn), m.oak, (0.7, 0.7, 0.7))
    for z in np.arange(-3.0, 3.1, 1.5):
        b.put(box((side, 0.18, 0.14), (0, HEIGHT - 0.09, z)), m.oak)


def _walls(b: Builder, m: Materials) -> None:
    """Add bookcases, posters, newspapers, tools and a rose engine's wheels on the four walls."""
    rng = np.random.default_rng(4)
    wood, books = bookcase(rng, 1.5, 6)
    poster, frame = framed_picture(0.8, 0.8)
    page, page_frame = framed_picture(1.0, 1.0)
    for turn in (0, 90, 180, 270):
        k = turn // 90
        for j, x in enumerate((-2.7, 0.2)) if k % 2 == 0 else enumerate((2.6,)):
            b.put(wood.shift(x, 0, -HALF + 0.03).turn_y(turn), m.oak)
            b.put(books.map_uv((1, 1), (0.3 * k, 0.25 * j)).shift(x, 0, -HALF + 0.03).turn_y(turn), m.spines)
        spots = (2.1, 3.2) if k % 2 == 0 else (-3.0, -1.9, -0.6, 0.6)
        for j, x in enumerate(spots):
            b.put(poster.shift(x, 2.45, -HALF + 0.02).turn_y(turn), m.posters[(j + k) % 4])
            b.put(frame.shift(x, 2.45, -HALF + 0.02).turn_y(turn), m.oak)
        for j, x in enumerate((2.6,) if k % 2 == 0 else (-2.5, -1.2, 0.3)):
            b.put(page.shift(x, 1.5, -HALF + 0.02).turn_y(turn), m.plan if j == 1 else m.paper)
            b.put(page_frame.shift(x, 1.5, -HALF + 0.02).turn_y(turn), m.oak)


def _furniture(b: Builder, m: Materials) -> None:
    """Add the pedestal of the turntable, benches with tools and castings, lamps on stands, cables."""
    b.put(
        lathe(
            [
                (0.5, TABLE - 0.1),
                (0.46, TABLE - 0.16),
                (0.3, 0.42),
                (0.24, 0.3),
                (0.3, 0.14),
                (0.62, 0.06),
                (0.62, 0.0),
            ],
            48,
        ),
        m.iron,
    )
    for k in range(12):
        a = np.pi / 6 * k
        b.put(cylinder(0.03, 0.05, 6).shift(0.56 * np.cos(a), 0.08, 0.56 * np.sin(a)), m.steel)
    for x, z, turn in ((3.55, -1.4, 90), (-3.55, 1.6, 90)):
        b.put(box((2.2, 0.07, 0.7), (0, 0.86, 0)).turn_y(turn).shift(x, 0, z), m.oak)
        for u in (-1.0, 1.0):
            for w in (-0.28, 0.28):
                b.put(box((0.08, 0.83, 0.08), (u, 0.415, w)).turn_y(turn).shift(x, 0, z), m.oak)
        for k, u in enumerate((-0.85, -0.45, -0.05, 0.35, 0.8)):
            vase = lathe(
                [(0, 0.3), (0.05, 0.3), (0.08, 0.22), (0.1 + 0.02 * (k % 3), 0.12), (0.06, 0.03), (0.08, 0.0)], 24
            )
            b.put(
                vase.shift(u, 0.895, 0.1 * (k % 2)).turn_y(turn).shift(x, 0, z), (m.stone, m.bronze, m.scrolls)[k % 3]
            )
    for (x, y, z), _ in LAMPS:
        way = np.array([-x, 1.3 - y, -z]) / np.linalg.norm([-x, 1.3 - y, -z])
        back = np.array([x, y, z]) - 0.18 * way
        right = np.cross(way, (0, 1, 0)) / np.linalg.norm(np.cross(way, (0, 1, 0)))
        up = np.cross(right, way)
        corner = back + 0.01 * way + 0.3 * right + 0.3 * up
        b.put(quad(corner, -0.6 * right, -0.6 * up), m.lamp)
        for s in (-1, 1):
            b.put(beam(back + 0.3 * s * right - 0.3 * up, back + 0.3 * s * right + 0.3 * up, 0.05), m.iron)
            b.put(beam(back - 0.3 * right + 0.3 * s * up, back + 0.3 * right + 0.3 * s * up, 0.05), m.iron)
        b.put(quad(corner - 0.02 * way - 0.6 * right, 0.6 * right, -0.6 * up), m.iron)
        foot = back - 0.08 * way
        b.put(tube([foot, (foot[0], 0.5, foot[2]), (foot[0], 0.02, foot[2])], 0.018, 8), m.iron)
        for a in np.arange(3) * 2 * np.pi / 3 + 0.4:
            end = (foot[0] + 0.36 * np.cos(a), 0.01, foot[2] + 0.36 * np.sin(a))
            b.put(tube([(foot[0], 0.5, foot[2]), end], 0.013, 6), m.iron)


def _routes() -> list[Route]:
    """Return ten viewpoints around the turntable, far and near."""
    return [
        tripod("south", (0.2, 1.6, 2.9), (0.0, 1.3, 0.0), 0.8),
        tripod("east", (2.8, 1.55, 0.3), (0.0, 1.3, 0.0), 0.8),
        tripod("south west", (-1.7, 1.75, 2.2), (0.0, 1.3, 0.0), 0.8),
        tripod("west", (-2.7, 1.6, -0.5), (0.0, 1.28, 0.0), 0.8),
        tripod("north east", (2.0, 1.9, -1.8), (0.0, 1.28, 0.0), 0.8),
        tripod("north", (-0.6, 1.5, -2.8), (0.0, 1.3, 0.0), 0.8),
        tripod("near the scale", (1.2, 1.3, 1.2), (0.05, 0.9, 0.0), 0.9),
        tripod("near the wheels", (-1.35, 1.5, 0.8), (0.0, 1.25, 0.1), 0.9),
        tripod("from above", (1.25, 2.6, 1.5), (0.0, 1.3, 0.0), 0.8),
        tripod("near the rings", (-0.8, 2.1, -1.3), (0.0, 1.9, 0.0), 0.9),
    ]


def turntable() -> Scene:
    """Build a studio of 8 x 8 m in which one carved machine turns in 24 s; all else stands, the cameras too."""
    b = Builder()
    m = Materials(b)
    for part in (_room, _walls, _furniture):
        part(b, m)
    b.move(machine(m), spin((0, TABLE, 0), (0, 1, 0), HERTZ))
    meshes, objects = b.build()
    return Scene(
        name="turntable",
        materials=b.materials,
        meshes=meshes,
        objects=objects,
        routes=_routes(),
        sun=None,
        points=[PointLight(place, light, 9.0) for place, light in LAMPS],
        sky=Sky((0.5, 0.55, 0.65), (0.5, 0.5, 0.5), (0.35, 0.3, 0.25), 0.5),
        exposure=1.0,
        near=0.1,
        far=30.0,
        attribution="Code and text: MIT. Letters: DejaVu fonts, Bitstream Vera licence.",
    )
