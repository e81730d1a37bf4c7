"""Market stalls: fruit, books and newspapers under striped canvas.

A stall stands about its origin and looks along +z.
"""

import numpy as np

from supersampling.scenes.kit.blocks import beam, box, quad
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, atlas_cell, grid, join
from supersampling.scenes.kit.site import Site
from supersampling.scenes.market.houses import canopy
from supersampling.scenes.market.materials import Palette
from supersampling.scenes.market.parts import board, crates


def tray(size: tuple[float, float], seed: int) -> tuple[Shape, Shape]:
    """Return an open wooden crate, its bottom on y = 0, and the heap of fruit in it."""
    w, d = size
    slats = [box((w, 0.07, 0.015), (0, y, z)) for z in (-d / 2, d / 2) for y in (0.04, 0.13)]
    slats += [box((0.015, 0.07, d), (x, y, 0)) for x in (-w / 2, w / 2) for y in (0.04, 0.13)]
    slats += [
        box((0.03, 0.18, 0.03), (x, 0.09, z))
        for x in (-w / 2 + 0.02, w / 2 - 0.02)
        for z in (-d / 2 + 0.02, d / 2 - 0.02)
    ]
    v, u = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    y = 0.1 + 0.11 * (1 - u**4) * (1 - v**4) + 0.015 * np.sin(7 * u + seed) * np.cos(5 * v + seed)
    points = np.stack([u * (w / 2 - 0.01), y, v * (d / 2 - 0.01)], -1)
    slope = np.stack([-np.gradient(y, axis=1) / (w / 8), np.ones_like(y), -np.gradient(y, axis=0) / (d / 8)], -1)
    normal = slope / np.linalg.norm(slope, axis=-1, keepdims=True)
    return join(slats), grid(points, normal, np.stack([u * w, v * d], -1) * 0.8 + 0.17 * seed)


def tag(index: int, scale: float = 1.0) -> tuple[Shape, Shape]:
    """Return the card (both sides) and the stick of a price tag that stands on y = 0."""
    card = box((0.2 * scale, 0.15 * scale, 0.006), (0, 0.24 * scale, 0), ("front", "back"), True)
    return card.map_uv(*atlas_cell(8, 8, index)), beam((0, 0, 0), (0, 0.2 * scale, 0), 0.012)


def _frame(site: Site, p: Palette, canvas: int, width: float) -> None:
    """Add posts, canvas roof with valances to both sides, table with a skirt."""
    for x in (-width / 2, width / 2):
        for z, top in ((-0.85, 2.35), (0.85, 2.35), (0.0, 2.95)):
            site.put(beam((x, 0.0 if z else 2.3, z), (x, top, z), 0.06), p.wood)
        site.put(join([beam((x, 2.3, -0.9), (x, 2.3, 0.9), 0.05), beam((x, 2.92, 0), (x, 2.28, 1.2), 0.04)]), p.wood)
    site.put(beam((-width / 2, 2.95, 0), (width / 2, 2.95, 0), 0.05), p.wood)
    half = canopy(width + 0.3, 1.3, 0.68)
    for turn in (0, 180):
        site.put(half.turn_y(turn).shift(0, 3.0, 0), p.awnings[canvas])
    site.put(box((width, 0.05, 1.5), (0, 0.82, 0.05)), p.wood)
    skirt = quad((-width / 2, 0.82, 0.79), (width, 0, 0), (0, -0.72, 0)).map_uv((width, 0.72), (0.3 * canvas, 0.1))
    site.put(skirt, p.sack)
    site.put(join([box((0.06, 0.8, 0.06), (x, 0.4, -0.6)) for x in np.linspace(-width / 2, width / 2, 3)]), p.wood)


def fruit_stall(site: Site, p: Palette, seed: int, width: float = 3.4) -> None:
    """Add two sloping rows of trays with tags, crates of labels before and behind, a slate."""
    _frame(site, p, seed % 3, width)
    tilt = rotation((1, 0, 0), 0.3)
    for row, (y, z) in enumerate(((0.9, 0.5), (1.1, 0.02))):
        for k in range(5):
            x = (k - 2) * width / 5.2
            wood, heap = tray((0.58, 0.44), k + 3 * row)
            site.put(wood.transform(tilt).shift(x, y, z), p.wood)
            site.put(heap.transform(tilt).shift(x, y, z), p.fruit[(k + row + seed) % 3])
            card, stick = tag(seed * 11 + 5 * row + k)
            site.put(card.shift(x + 0.08, y + 0.22, z - 0.1), p.tags)
            site.put(stick.shift(x + 0.08, y + 0.22, z - 0.1), p.wood)
    for k in range(4):
        crates(site, p, (-width / 2 + 0.4 + k * 0.88, 0.98 if k % 2 else 1.02), seed * 5 + k, 1)
    board(site, p, p.slates[seed % 3], (width / 2 - 0.4, 1.9, -0.8), (0.5, 0.75))
    board(site, p, p.bills[seed % 5], (-width / 2 + 0.5, 1.85, -0.8), (0.75, 0.75))
    for k in range(6):
        board(site, p, p.tags, (-1.2 + 0.48 * k, 2.14, 0.93), (0.3, 0.22), atlas_cell(8, 8, 17 * seed + 3 * k))


def book_stall(site: Site, p: Palette, seed: int, width: float = 3.4) -> None:
    """Add rows of spines at the back, tilted rows of covers in front, a few papers and tags."""
    _frame(site, p, seed % 3, width)
    rng = np.random.default_rng(seed)
    strip = box((1.06, 0.3, 0.22), (0, 0.15, 0), ("front", "back", "top"), True).map_uv((1, 0.25))
    for row, (y, z) in enumerate(((0.85, -0.3), (1.22, -0.45), (1.59, -0.45))):
        site.put(box((width, 0.03, 0.3), (0, y - 0.015, z)), p.wood)
        for k in range(3):
            site.put(strip.map_uv((1, 1), (0.31 * k, (row + k + seed) % 4 / 4)).shift((k - 1) * 1.1, y, z), p.spines)
    book = box((0.3, 0.36, 0.035), (0, 0.18, 0), fit=True)
    lean = rotation((1, 0, 0), -0.5)
    for row, (y, z) in enumerate(((0.86, 0.62), (0.92, 0.28))):
        for k in range(9):
            cell = int(rng.integers(16))
            site.put(book.map_uv(*atlas_cell(4, 4, cell)).transform(lean).shift((k - 4) * 0.37, y, z), p.covers)
            if k % 2 == row:
                card, stick = tag(seed * 7 + k, 0.7)
                site.put(join([card]).shift((k - 4) * 0.37 + 0.18, y + 0.02, z + 0.06), p.tags)
                site.put(stick.shift((k - 4) * 0.37 + 0.18, y + 0.02, z + 0.06), p.wood)
    for k in range(2):
        board(site, p, p.papers[(seed + k) % 2], (-0.9 + 1.8 * k, 0.44, 0.83), (0.66, 0.66))
    for k in range(4):
        board(site, p, p.bills[(seed + k) % 5], (-1.26 + 0.84 * k, 1.42, -0.9), (0.78, 1.0), flip=True)


def press_stall(site: Site, p: Palette, seed: int, width: float = 3.4) -> None:
    """Add newspapers on a rack, in piles and hung up; posters and cards behind."""
    _frame(site, p, seed % 3, width)
    sheet = quad((-0.26, 0.62, 0), (0.52, 0, 0), (0, -0.62, 0.0))
    lean = rotation((1, 0, 0), -0.65)
    for k in range(6):
        site.put(sheet.transform(lean).shift((k - 2.5) * 0.56, 0.87, 0.7), p.papers[k % 2])
        site.put(box((0.5, 0.1 + 0.03 * (k % 3), 0.36), ((k - 2.5) * 0.56, 0.91, 0.0), fit=True), p.papers[(k + 1) % 2])
        board(site, p, (p.papers, p.bills)[k % 2][k % 2], ((k - 2.5) * 0.56, 1.66, -0.7), (0.52, 0.6))
        board(site, p, p.bills[(k + seed) % 5], ((k - 2.5) * 0.56, 1.45, -0.9), (0.52, 0.7), flip=True)
        board(site, p, p.tags, ((k - 2.5) * 0.56, 1.24, -0.66), (0.5, 0.16), atlas_cell(2, 8, k + seed))
    for k in range(3):
        board(site, p, p.papers[k % 2], (-1.1 + 1.1 * k, 0.44, 0.83), (0.7, 0.68))
