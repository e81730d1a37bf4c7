"""Houses around the market: pierced facades, windows with shutters, shop fronts, awnings and roofs.

A house stands in its own frame: its front runs along +x from the origin, looks along +z and rises from y = 0.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np

from supersampling.scenes.kit.blocks import beam, box, panel, quad
from supersampling.scenes.kit.builder import Color
from supersampling.scenes.kit.shapes import Shape, atlas_cell, cylinder, grid, join, tube
from supersampling.scenes.kit.site import WHITE, Site
from supersampling.scenes.market.materials import Palette

SHOP, STOREY, DEPTH = 3.7, 2.75, 5.0  # metres: ground floor, upper floors, how far a house reaches back
PANE = (1.05, 1.6)
_TRIM: Color = (0.86, 0.83, 0.76)


@dataclass(frozen=True)
class House:
    """House of brick or plaster in a tint; ``columns`` are windows per storey, ``shop`` is the number of its shop."""

    width: float
    storeys: int
    columns: int
    brick: bool
    tint: Color
    shutters: Color
    shop: int

    @property
    def height(self) -> float:
        return SHOP + STOREY * self.storeys + 0.35


def pierced(width: float, height: float, holes: list[tuple[float, float, float, float]]) -> Shape:
    """Return a wall with rectangular holes ``(x0, x1, y0, y1)``; metric uv; no T-junctions."""
    xs = sorted({0.0, width, *(v for h in holes for v in h[:2])})
    ys = sorted({0.0, height, *(v for h in holes for v in h[2:])})
    cells = []
    for x0, x1 in pairwise(xs):
        for y0, y1 in pairwise(ys):
            x, y = (x0 + x1) / 2, (y0 + y1) / 2
            if not any(h[0] < x < h[1] and h[2] < y < h[3] for h in holes):
                cells.append(panel((x0, y1, 0), (x1 - x0, 0, 0), (0, y0 - y1, 0)))
    return join(cells)


def recess(width: float, height: float, depth: float) -> Shape:
    """Return the four sides of a hole whose lower left corner is the origin."""
    return join(
        [
            panel((0, 0, -depth), (width, 0, 0), (0, 0, depth)),
            panel((0, height, 0), (width, 0, 0), (0, 0, -depth)),
            panel((0, height, 0), (0, 0, -depth), (0, -height, 0)),
            panel((width, height, -depth), (0, 0, depth), (0, -height, 0)),
        ]
    )


@cache
def _window() -> tuple[Shape, Shape, Shape, Shape, Shape]:
    """Return the reveal, frame, panes, shutters and stone trim of a window.

    Its middle is over the origin, its sill on it.
    """
    w, h = PANE
    bars = [box((0.06, h, 0.06), (x, h / 2, -0.14)) for x in (-w / 2 + 0.03, 0, w / 2 - 0.03)]
    bars += [box((w, 0.06, 0.06), (0, y, -0.14)) for y in (0.03, h * 0.68, h - 0.03)]
    bars += [box((w, 0.025, 0.04), (0, y, -0.14), ("front", "top", "bottom")) for y in (h * 0.36, h * 0.84)]
    shutter = box((w / 2, h, 0.045), (0, h / 2, 0.04), fit=True)
    shutters = [shutter.shift(side * (w * 0.75 + 0.07), 0, 0) for side in (-1, 1)]
    trim = [box((w + 0.3, 0.1, 0.2), (0, -0.05, 0.06)), box((w + 0.24, 0.2, 0.08), (0, h + 0.1, 0.03))]
    trim += [box((0.2, 0.26, 0.12), (0, h + 0.12, 0.05))]
    trim += [box((0.1, h, 0.05), (side * (w / 2 + 0.03), h / 2, 0.0), ("front", "left", "right")) for side in (-1, 1)]
    pane = quad((-w / 2, h, -0.16), (w, 0, 0), (0, -h, 0))
    return recess(w, h, 0.2).shift(-w / 2, 0, 0), join(bars), pane, join(shutters), join(trim)


def canopy(width: float, reach: float, drop: float) -> Shape:
    """Return an awning from a wall at the origin's height out to ``reach``, with a scalloped valance.

    u runs across, v outwards.
    """
    slope = quad((-width / 2, 0, 0), (width, 0, 0), (0, -drop, reach)).map_uv((width, reach))
    count = max(round(width / 0.25), 1)
    x = np.linspace(-width / 2, width / 2, 6 * count + 1)
    lower = -drop - 0.14 - 0.1 * np.abs(np.sin(np.pi * (x + width / 2) * count / width))
    rows = np.stack([np.stack([x, 0 * x - drop, 0 * x + reach], 1), np.stack([x, lower, 0 * x + reach], 1)])
    uv = np.stack([rows[..., 0] + width / 2, reach - drop - rows[..., 1]], -1)
    return join([slope, grid(rows, np.broadcast_to([0.0, 0.0, 1.0], rows.shape), uv)])


def _roof(site: Site, p: Palette, house: House) -> None:
    """Add a gabled roof with its ridge along the street, gutters, chimney; side walls above lower neighbours."""
    w, h = house.width, house.height
    wall = p.brick if house.brick else p.plaster
    rise, middle = 2.6, -DEPTH / 2
    for eaves in (0.45, -DEPTH - 0.3):
        front = eaves > middle
        corner, along = (-0.02, w + 0.04) if front else (w + 0.02, -w - 0.04)
        slope = quad((corner, h + rise, middle), (along, 0, 0), (0, -rise - 0.4, eaves - middle))
        site.put(slope.map_uv((w, 4.2)), p.roof)
    for x, turn in ((0.0, -1), (w, 1)):
        side = panel((x, h, 0 if turn > 0 else -DEPTH), (0, 0, -turn * DEPTH), (0, -h, 0))
        gable = Shape(
            np.array([(x, h, 0), (x, h, -DEPTH), (x, h + rise, middle)], float),
            np.tile([float(turn), 0.0, 0.0], (3, 1)),
            np.array([(0, 0), (DEPTH, 0), (DEPTH / 2, -rise)], float),
            np.array([[0, 1, 2] if turn > 0 else [1, 0, 2]]),
        )
        site.put(join([side, gable]), wall, house.tint)
    site.put(box((w, 0.16, 0.34), (w / 2, h - 0.02, 0.17)), p.stone, _TRIM)
    site.put(box((w, 0.12, 0.2), (w / 2, h - 0.16, 0.1)), p.stone, _TRIM)
    site.put(tube([(0.02, h - 0.05, 0.5), (w - 0.02, h - 0.05, 0.5)], 0.07, 8), p.iron)
    site.put(tube([(w - 0.12, h - 0.05, 0.46), (w - 0.12, h - 0.5, 0.1), (w - 0.12, 0.0, 0.1)], 0.045, 8), p.iron)
    site.put(box((0.7, 2.2, 0.7), (w * 0.3, h + rise, middle + 0.5)), p.brick)
    for offset in (-0.18, 0.18):
        site.put(cylinder(0.12, 0.4, 10).shift(w * 0.3 + offset, h + rise + 1.28, middle + 0.5), p.roof)


def _shop(site: Site, p: Palette, house: House) -> None:
    """Add a shop front: door, stall riser, shelves of goods behind mullions, fascia, awning."""
    w, left, right = house.width, 0.55, house.width - 0.55
    k, glass = house.shop, right - left - 1.3
    site.put(recess(right - left, 2.9, 0.7).shift(left, 0, 0), p.paint, house.shutters)
    site.put(
        quad((left, 2.9, -0.7), (right - left, 0, 0), (0, -2.9, 0)).map_uv((right - left, 2.9)),
        p.wood,
        (0.5, 0.45, 0.4),
    )
    wood = [
        box((glass, 0.7, 0.1), (left + glass / 2, 0.35, -0.05)),
        box((glass, 0.06, 0.22), (left + glass / 2, 0.72, 0.02)),
    ]
    wood += [
        box((0.09, 2.9, 0.12), (x, 1.45, -0.05))
        for x in np.linspace(left + 0.05, left + glass, max(round(glass / 1.1), 1) + 1)
    ]
    wood += [
        box((right - left, 0.1, 0.12), (w / 2, 2.85, -0.05)),
        box((glass, 0.06, 0.1), (left + glass / 2, 2.3, -0.06)),
    ]
    wood += [box((1.1, 2.4, 0.06), (right - 0.62, 1.2, -0.2)), box((1.3, 0.08, 0.14), (right - 0.62, 2.44, -0.1))]
    wood += [box((0.34, 0.7, 0.03), (right - 0.62 + s * 0.24, 0.55, -0.16)) for s in (-1, 1)]
    site.put(join(wood), p.paint, house.shutters)
    site.put(quad((right - 1.05, 2.25, -0.165), (0.86, 0, 0), (0, -1.2, 0)), (p.slates[k % 3], p.bills[k % 5])[k % 2])
    site.put(box((1.4, 0.12, 0.5), (right - 0.62, 0.06, 0.1)), p.stone)
    _goods(site, p, k, (left, glass))
    board = box((w - 0.7, 0.52, 0.1), (w / 2, 3.24, 0.06), ("front", "top", "bottom", "left", "right"), True)
    site.put(board, p.boards[k % 6])
    site.put(box((w - 0.5, 0.09, 0.24), (w / 2, 3.55, 0.1)), p.stone, _TRIM)
    site.put(canopy(glass + 0.3, 1.25, 0.6).shift(left + glass / 2, 2.94, 0.06), p.awnings[k % 3])
    for side in (-1, 1):
        x = left + glass / 2 + side * (glass / 2 + 0.13)
        site.put(
            join([beam((x, 2.3, 0.06), (x, 2.33, 1.3), 0.025), beam((x, 2.9, 0.06), (x, 2.34, 1.28), 0.02)]), p.iron
        )


def _goods(site: Site, p: Palette, shop: int, glass: tuple[float, float]) -> None:
    """Add three shelves behind a shop window: books, or labelled boxes and covers.

    ``glass`` is the left edge and the width of the window.
    """
    left, width = glass
    rng = np.random.default_rng(70 + shop)
    unit = box((0.4, 0.34, 0.3), (0, 0.17, 0), ("front", "left", "right", "top"), True)
    strip = box((0.96, 0.3, 0.26), (0, 0.15, 0), ("front", "top"), True).map_uv((1, 0.25))
    for row, y in enumerate((0.76, 1.3, 1.84)):
        site.put(box((width, 0.04, 0.4), (left + width / 2, y - 0.02, -0.45)), p.wood)
        x = left + 0.32
        while x < left + width - 0.25:
            cell = int(rng.integers(16))
            if (shop + row) % 3 == 0:
                site.put(
                    strip.map_uv((1, 1), (0, cell % 4 / 4)).shift(min(x + 0.25, left + width - 0.5), y, -0.42), p.spines
                )
                x += 0.98
                continue
            site.put(unit.map_uv(*atlas_cell(4, 4, cell)).shift(x, y, -0.42), (p.crates, p.covers)[(shop + row) % 2])
            x += 0.46


def build(site: Site, p: Palette, house: House) -> None:
    """Add the whole house."""
    w, h = house.width, house.height
    wall = p.brick if house.brick else p.plaster
    pitch = w / house.columns
    windows = [
        (pitch * (c + 0.5), SHOP + 0.65 + STOREY * s) for s in range(house.storeys) for c in range(house.columns)
    ]
    holes = [(x - PANE[0] / 2, x + PANE[0] / 2, y, y + PANE[1]) for x, y in windows]
    site.put(pierced(w, h, [*holes, (0.55, w - 0.55, 0.0, 2.9)]), wall, house.tint)
    reveal, frame, pane, shutters, trim = _window()
    for k, (x, y) in enumerate(windows):
        for shape, material, color in (
            (reveal, p.plaster, WHITE),
            (frame, p.paint, WHITE),
            (pane, p.window, WHITE),
            (trim, p.stone, _TRIM),
        ):
            site.put(shape.shift(x, y, 0), material, color)
        if pitch > 2.1:
            site.put(shutters.shift(x, y, 0), p.shutter, house.shutters)
        if (k * 7 + house.shop) % 3 == 0:
            flower_box(site, p, (x, y - 0.1), 10 * house.shop + k)
    for s in range(house.storeys):
        site.put(
            box((w, 0.14, 0.1), (w / 2, SHOP + 0.15 + STOREY * s, 0.04), ("front", "top", "bottom")), p.stone, _TRIM
        )
    for x in (0.16, w - 0.16):
        for j in range(int(h / 0.36)):
            wide = 0.46 if j % 2 else 0.32
            site.put(
                box((wide, 0.33, 0.07), (x, 0.2 + 0.36 * j, 0.02), ("front", "left", "right", "top", "bottom")),
                p.stone,
                _TRIM,
            )
    _shop(site, p, house)
    _roof(site, p, house)


def flower_box(site: Site, p: Palette, place: tuple[float, float], seed: int) -> None:
    """Add a planter on a sill, with hanging geraniums."""
    site.put(box((1.0, 0.18, 0.2), (place[0], place[1] + 0.02, 0.26)), p.wood)
    rng = np.random.default_rng(seed)
    for k in range(9):
        size = rng.uniform(0.3, 0.42)
        card = quad((-size / 2, size, 0), (size, 0, 0), (0, -size, 0.12)).map_uv((0.6, 0.6), (k * 0.13, k * 0.21))
        card = card.turn_y(float(rng.uniform(-70, 70)))
        site.put(card.shift(place[0] - 0.42 + 0.105 * k, place[1] - 0.12 + float(rng.uniform(0, 0.16)), 0.3), p.flowers)
