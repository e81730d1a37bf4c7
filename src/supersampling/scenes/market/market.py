"""The built-in scene ``market``: a town square of 30 x 20 m on a market day, under a low sun."""

import numpy as np

from supersampling.scenes.kit.blocks import beam, box, panel, quad
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.routes import walk
from supersampling.scenes.kit.shapes import Point, Shape, join, lathe
from supersampling.scenes.kit.site import Site
from supersampling.scenes.market import parts, stalls
from supersampling.scenes.market.houses import House, build
from supersampling.scenes.market.materials import Palette
from supersampling.scenes.market.motion import movers
from supersampling.scenes.scene import Route, Scene, Sky, Sun

X, Z = 15.0, 10.0  # half the square
_CREAM, _ROSE, _OCHRE, _GREY = (0.86, 0.78, 0.58), (0.8, 0.5, 0.38), (0.82, 0.6, 0.28), (0.7, 0.72, 0.68)
_GREEN, _BLUE, _BROWN, _RED = (0.16, 0.32, 0.2), (0.2, 0.34, 0.46), (0.36, 0.22, 0.14), (0.5, 0.14, 0.1)
NORTH = (
    House(8.0, 2, 3, False, _CREAM, _GREEN, 0),
    House(7.0, 3, 3, True, (1.0, 0.95, 0.9), _BROWN, 1),
    House(8.0, 2, 3, False, _ROSE, _BLUE, 2),
    House(7.0, 3, 3, False, _GREY, _RED, 3),
)
SOUTH = (
    House(8.0, 1, 3, True, (0.95, 0.9, 0.85), _GREEN, 4),
    House(7.5, 2, 3, False, _OCHRE, _BROWN, 5),
    House(7.5, 1, 3, False, _GREY, _BLUE, 0),
    House(7.0, 2, 3, False, _CREAM, _RED, 1),
)
EAST = (
    House(6.0, 2, 2, False, _OCHRE, _BLUE, 2),
    House(8.0, 3, 4, True, (1.0, 0.92, 0.84), _GREEN, 3),
    House(6.0, 2, 2, False, _ROSE, _GREEN, 4),
)


def _row(b: Builder, p: Palette, houses: tuple[House, ...], turn: float, start: Point) -> None:
    """Add houses side by side from ``start`` along the local +x."""
    along = rotation((0, 1, 0), np.radians(turn))[:3, 0]
    corner = np.asarray(start)
    for house in houses:
        build(Site(b, turn, float(corner[0]), float(corner[2])), p, house)
        corner = corner + along * house.width


def _ground(b: Builder, p: Palette) -> None:
    """Add fan-laid cobbles in fields between bands of dressed stone; setts along the houses."""
    for x in np.arange(-X, X, 6.0):
        for k, z in enumerate((-6.4, -2.1, 2.2)):
            tint = 0.84 + 0.08 * ((int(x) + 2 * k) % 3)
            field = panel((x + 0.2, 0, z + 0.15), (5.6, 0, 0), (0, 0, 4.0))
            b.put(field, p.fans, (tint, tint, tint))
            b.put(panel((x + 5.8, 0, z + 0.15), (0.4, 0, 0), (0, 0, 4.0)), p.stone, (0.74, 0.72, 0.7))
    for z in (-6.55, -2.25, 2.05, 6.2):
        b.put(panel((-X, 0, z), (2 * X, 0, 0), (0, 0, 0.3)), p.stone, (0.74, 0.72, 0.7))
    for z in (-Z, 6.5):
        b.put(panel((-X, 0, z), (2 * X, 0, 0), (0, 0, Z - 6.5 - (0.05 if z < 0 else 0))), p.setts, (0.86, 0.84, 0.82))
    b.put(panel((-X, 0, -6.4), (0.2, 0, 0), (0, 0, 12.6)), p.stone, (0.74, 0.72, 0.7))
    b.put(panel((-44, 0, -30), (29, 0, 0), (0, 0, 60)), p.setts, (0.62, 0.6, 0.58))


def _west(b: Builder, p: Palette) -> None:
    """Add a low wall with a gate, over which the sun shines, and the town's roofs behind it."""
    for z0, z1 in ((-10.0, -2.6), (2.6, 10.0)):
        length, middle = z1 - z0, (z0 + z1) / 2
        b.put(box((0.4, 2.3, length), (-X - 0.2, 1.15, middle)), p.brick, (0.95, 0.9, 0.86))
        b.put(box((0.56, 0.14, length), (-X - 0.2, 2.37, middle)), p.stone)
        b.put(box((0.5, 0.4, length), (-X - 0.2, 0.2, middle)), p.stone)
        wall = Site(b, 90, -X + 0.02, middle)
        for k in range(5):
            sheet = (p.bills[k], p.papers[k % 2], p.bills[(k + 2) % 5])[k % 3]
            parts.board(wall, p, sheet, (-2.8 + 1.4 * k, 1.35, 0.03), (1.0, 1.0))
    for z in (-2.4, 2.4):
        b.put(box((0.8, 3.2, 0.8), (-X - 0.2, 1.6, z)), p.stone)
        b.put(box((1.0, 0.2, 1.0), (-X - 0.2, 3.3, z)), p.stone)
        b.put(
            lathe([(0, 0.62), (0.2, 0.55), (0.28, 0.34), (0.2, 0.12), (0.12, 0.0)], 16).shift(-X - 0.2, 3.4, z), p.stone
        )
    tints, shutters = (_CREAM, _GREY, _ROSE, _OCHRE), (_RED, _GREEN, _BLUE)
    back = tuple(House(8.0, 1 + k % 2, 3, k % 3 == 1, tints[k % 4], shutters[k % 3], k) for k in range(7))
    _row(b, p, back, 90, (-36.0, 0, 28.0))
    for k, z in enumerate((-14.5, 14.5)):
        parts.linden(Site(b, 0, -21.0, z), p, 90 + k, 6.5)


def _town_hall(b: Builder, p: Palette) -> None:
    """Add the inscribed band, the clock and the pediment on the middle house of the east side."""
    site = Site(b, -90, X, -4.0)
    band = quad((0.6, 7.05, 0.13), (6.8, 0, 0), (0, -0.52, 0))
    site.put(band, p.frieze)
    site.put(box((7.0, 0.62, 0.1), (4.0, 6.79, 0.06)), p.stone)
    gable = [box((3.4, 0.2, 3.4), (4.0, y, -1.48)) for y in (12.5, 15.4)]
    gable += [box((0.34, 2.8, 0.12), (4.0 + x, 13.95, 0.06)) for x in (-1.35, 1.35)]
    site.put(join(gable), p.stone)
    site.put(box((3.0, 3.6, 3.0), (4.0, 13.7, -1.48)), p.brick, (1.0, 0.92, 0.84))
    site.put(parts.frustum(1.75, 0.04, 15.5, 17.6).shift(4.0, 0, -1.48), p.roof)
    site.put(box((1.96, 1.96, 0.08), (4.0, 13.95, 0.04)), p.stone)
    site.put(quad((3.1, 14.85, 0.085), (1.8, 0, 0), (0, -1.8, 0)), p.clock)
    hands = [
        beam((4.0, 13.95, 0.1), (4.3, 14.38, 0.1), 0.07, 0.02),
        beam((4.0, 13.95, 0.13), (3.36, 13.82, 0.13), 0.045, 0.02),
    ]
    site.put(join(hands), p.iron)


def _stalls(b: Builder, p: Palette) -> None:
    """Add two rows of stalls, with crates, slates, lamps and lindens between them."""
    stalls.fruit_stall(Site(b, 0, -8.6, -3.6), p, 0)
    stalls.book_stall(Site(b, 0, -3.8, -3.7), p, 1)
    stalls.press_stall(Site(b, 0, 4.6, -3.7), p, 2)
    stalls.fruit_stall(Site(b, 0, 9.4, -3.6), p, 4)
    stalls.press_stall(Site(b, 180, -7.2, 3.9), p, 3)
    stalls.fruit_stall(Site(b, 180, -2.2, 3.9), p, 5)
    stalls.book_stall(Site(b, 180, 5.0, 3.9), p, 6)
    stalls.book_stall(Site(b, 180, 9.9, 3.9), p, 9)
    parts.column(Site(b, 0, 0.4, -3.6), p)
    parts.monument(Site(b, 12, 1.4, 3.6), p)
    for k, (x, z) in enumerate(((-11.0, -4.6), (-11.0, 4.6), (12.9, -5.3))):
        parts.linden(Site(b, 70 * k, x, z), p, 80 + k)
    for x, z in ((-6.2, -6.0), (2.5, -6.0), (7.2, 6.0), (-4.6, 6.0), (13.0, 2.2)):
        parts.lamp(Site(b, 0, x, z), p)
    easels = ((-10.2, -7.9, 12), (-4.4, -8.0, -10), (3.8, -8.0, 8), (10.4, -7.9, -6), (-9.8, 8.0, 170),
              (-1.6, 8.1, 188), (6.2, 8.0, 176), (-6.2, -1.6, 30), (2.6, -1.9, -12), (7.2, 2.0, 200))  # fmt: skip
    for k, (x, z, turn) in enumerate(easels):
        parts.easel(Site(b, turn, x, z), p, (p.slates[k % 3], p.bills[k % 5])[k % 2])
    piles = ((-12.4, -8.8, 3), (-8.2, -9.0, 2), (-2.0, -9.2, 3), (5.6, -9.1, 2), (12.9, -8.9, 3), (-12.6, 9.0, 2),
             (-4.4, 9.2, 3), (4.0, 9.1, 2), (12.6, 9.0, 3), (-6.4, -4.4, 2), (-6.0, -3.9, 1), (2.4, -4.3, 3),
             (7.0, -4.2, 2), (-4.6, 4.3, 3), (7.4, 4.5, 2), (13.9, -6.8, 3), (13.9, 4.9, 2),
             (14.0, 7.0, 3))  # fmt: skip
    for k, (x, z, high) in enumerate(piles):
        parts.crates(Site(b, 0, 0, 0), p, (x, z), k, high)
        parts.crates(Site(b, 0, 0, 0), p, (x + 0.5, z + 0.06 * (k % 3)), k + 7, max(high - 1, 1))


def _ivy(b: Builder, p: Palette) -> None:
    """Add ivy over parts of the facades."""
    rng, cards = np.random.default_rng(33), []
    for k in range(110):
        x = -8.2 + rng.normal() * 0.55
        y = abs(rng.normal()) * 2.6 + 0.2
        size = rng.uniform(0.5, 0.8)
        card = quad((-size / 2, size / 2, 0), (size, 0, 0), (0, -size, 0.1)).map_uv(
            (1.0, 1.0), (k * 0.37 % 1, k * 0.23 % 1)
        )
        cards.append(card.turn_y(float(rng.uniform(-30, 30))).shift(x, min(y, 7.0), -Z + 0.14 + 0.1 * rng.random()))
    b.put(Shape.shift(join(cards), 1.2, 0, 0), p.ivy)


def _routes() -> list[Route]:
    return [
        walk("middle aisle eastwards", [(-9.6, 1.65, -0.2), (6.5, 1.65, 0.1)], [(-6.0, 1.7, -5.0), (13.5, 2.4, -3.2)]),
        walk("north shops", [(-9.5, 1.6, -6.9), (9.0, 1.6, -7.0)], [(-5.5, 2.2, -10.0), (14.0, 2.4, -8.2)]),
        walk("books and papers", [(8.8, 1.6, 0.9), (-1.5, 1.6, 0.7)], [(4.8, 1.2, -4.5), (-5.5, 1.3, -4.5)]),
        walk("south stalls", [(-9.2, 1.6, 0.2), (4.5, 1.65, 0.5)], [(-5.0, 1.3, 4.2), (10.5, 1.4, 4.6)]),
        walk("to the column", [(11.0, 1.65, -6.9), (3.4, 1.6, -6.6)], [(4.0, 1.8, -3.2), (-3.5, 1.9, -4.2)]),
        walk("south shops", [(9.5, 1.6, 7.0), (-6.5, 1.6, 7.1)], [(5.0, 1.9, 10.0), (-11.5, 2.0, 9.4)]),
        walk("town hall", [(-4.2, 1.7, 0.4), (9.6, 1.7, -0.4)], [(12.0, 3.6, -2.0), (15.5, 3.8, -1.0)]),
        walk("monument", [(-2.6, 1.65, 1.0), (7.0, 1.6, 1.0)], [(1.0, 1.6, 4.2), (3.0, 1.7, 4.6)]),
        walk("gate side", [(-10.3, 1.65, -2.4), (-9.4, 1.7, 2.9)], [(-4.0, 2.0, -6.5), (-3.6, 2.2, -4.4)]),
        walk(
            "east end",
            [(12.5, 1.65, 6.9), (12.4, 1.65, 3.4), (9.4, 1.6, -0.6)],
            [(9.0, 2.0, 2.0), (4.0, 2.2, -4.0), (2.0, 2.0, -4.6)],
        ),
    ]


def market() -> Scene:
    """Build a town square on a market day: cobbles, facades, print everywhere, leaves; a few things move, slowly."""
    b = Builder()
    p = Palette(b)
    _ground(b, p)
    _row(b, p, NORTH, 0, (-X, 0, -Z))
    _row(b, p, EAST, -90, (X, 0, -Z))
    _row(b, p, SOUTH, 180, (X, 0, Z))
    _west(b, p)
    _town_hall(b, p)
    _stalls(b, p)
    _ivy(b, p)
    movers(b, p, (((-7.0, 4.9, -Z), 0), ((7.0 + 1.0, 4.9, -Z), 0), ((7.6, 4.6, Z), 180), ((X, 4.9, 4.0), -90)))
    meshes, objects = b.build()
    return Scene(
        "market",
        b.materials,
        meshes,
        objects,
        _routes(),
        sun=Sun((-0.82, 0.46, 0.34), (4.6, 3.6, 2.5)),
        sky=Sky((0.2, 0.38, 0.8), (0.72, 0.74, 0.78), (0.26, 0.23, 0.2), 0.74),
        exposure=0.85,
        near=0.1,
        far=120.0,
        attribution="Code and text: MIT. Gravel: scikit-image's photograph, CC0. Letters: DejaVu fonts, "
        "Bitstream Vera licence.",
    )
