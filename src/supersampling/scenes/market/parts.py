"""Static parts of the market: crates, an advertising column, lamp posts, lindens, a monument, slates."""

import numpy as np

from supersampling.scenes.kit.blocks import beam, box, quad
from supersampling.scenes.kit.builder import Color
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, atlas_cell, cylinder, grid, join, lathe, sphere, tube
from supersampling.scenes.kit.site import WHITE, Site
from supersampling.scenes.market.materials import Palette


def board(
    site: Site,
    p: Palette,
    material: int,
    place: tuple[float, float, float],
    size: tuple[float, float],
    uv: tuple[tuple[float, float], tuple[float, float]] = ((1.0, 1.0), (0.0, 0.0)),
    flip: bool = False,
) -> None:
    """Add a board with a sheet on its face, its middle at ``place``; ``flip`` turns it to the back of the stall."""
    face = quad((-size[0] / 2, size[1] / 2, 0.013), (size[0], 0, 0), (0, -size[1], 0)).map_uv(*uv)
    back = box((size[0] + 0.03, size[1] + 0.03, 0.02))
    turn = 180 if flip else 0
    site.put(face.turn_y(turn).shift(*place), material)
    site.put(back.turn_y(turn).shift(*place), p.wood)


def frustum(bottom: float, top: float, low: float, high: float) -> Shape:
    """Return the four sides of a square tapering block; half widths below and above."""
    side = []
    for turn in range(4):
        rows = np.array([[(-top, high, top), (top, high, top)], [(-bottom, low, bottom), (bottom, low, bottom)]])
        normal = np.array([0.0, bottom - top, high - low]) / np.hypot(bottom - top, high - low)
        side.append(grid(rows, np.broadcast_to(normal, rows.shape), rows[..., :2] * [1, -1]).turn_y(90 * turn))
    return join(side)


def crates(site: Site, p: Palette, place: tuple[float, float], seed: int, high: int = 2) -> None:
    """Add a pile of labelled crates at ``place`` (x, z)."""
    y = 0.0
    for k in range(high):
        size = (0.46, 0.4, 0.36)[(seed + k) % 3]
        crate = box((size, size * 0.86, size), (0, size * 0.43, 0), fit=True).map_uv(
            *atlas_cell(4, 4, seed * 5 + 3 * k)
        )
        site.put(crate.turn_y(23 * (seed + k) % 31 - 15).shift(place[0], y, place[1]), p.crates)
        y += size * 0.86


def column(site: Site, p: Palette) -> None:
    """Add an advertising column: stone foot, three rows of bills and papers, a crown."""
    site.put(lathe([(0.62, 0.5), (0.72, 0.44), (0.72, 0.1), (0.8, 0.1), (0.8, 0.0)], 32), p.stone)
    site.put(cylinder(0.6, 2.5, 32, False).shift(0, 1.7, 0), p.plaster, (0.8, 0.76, 0.66))
    for row, (y, high) in enumerate(((0.56, 0.72), (1.32, 0.86), (2.22, 0.64))):
        for k in range(6):
            angle = np.linspace(0, 0.98 * np.pi / 3, 7) + k * np.pi / 3 + 0.4 * row
            rows = np.stack(
                [np.stack([0.606 * np.sin(angle), 0 * angle + h, 0.606 * np.cos(angle)], 1) for h in (y + high, y)]
            )
            normal = np.broadcast_to(np.stack([np.sin(angle), 0 * angle, np.cos(angle)], 1), rows.shape)
            v, u = np.meshgrid([0.0, 1.0], np.linspace(0, 1, 7), indexing="ij")
            sheet = (*p.bills, p.notice, *p.papers)[(k * 3 + row * 2) % 8]
            site.put(grid(rows, normal, np.stack([u, v], -1)), sheet)
    crown = [
        (0, 3.75),
        (0.06, 3.6),
        (0.05, 3.5),
        (0.3, 3.36),
        (0.56, 3.2),
        (0.7, 3.12),
        (0.76, 3.02),
        (0.76, 2.94),
        (0.6, 2.9),
    ]
    site.put(lathe(crown, 32), p.iron, (0.7, 1.0, 0.85))
    site.put(sphere(0.1, 12).shift(0, 3.78, 0), p.iron)


def lamp(site: Site, p: Palette) -> None:
    """Add a street lamp, unlit by day, with a notice on its post."""
    post = [
        (0.05, 3.1),
        (0.05, 2.4),
        (0.075, 2.36),
        (0.06, 2.3),
        (0.07, 1.0),
        (0.13, 0.9),
        (0.1, 0.8),
        (0.14, 0.3),
        (0.2, 0.22),
        (0.22, 0.0),
    ]
    site.put(lathe(post, 14), p.iron)
    cage = [beam((0.1 * x, 3.12, 0.1 * z), (0.17 * x, 3.56, 0.17 * z), 0.022) for x in (-1, 1) for z in (-1, 1)]
    cage += [lathe([(0.02, 3.86), (0.06, 3.76), (0.27, 3.58), (0.26, 3.55)], 8), lathe([(0.16, 3.13), (0.05, 3.08)], 8)]
    cage += [beam((-0.36, 2.72, 0), (0.36, 2.72, 0), 0.03)]
    site.put(join(cage), p.iron)
    site.put(frustum(0.075, 0.14, 3.13, 3.55), p.plaster, (0.75, 0.78, 0.72))
    board(site, p, p.bills[int(abs(site.x * 3)) % 5], (0, 1.75, 0.1), (0.42, 0.56))


def linden(site: Site, p: Palette, seed: int, height: float = 5.4) -> None:
    """Add a tree with a crown of leaf cards, and a ring of setts and an iron grid around its foot."""
    rng = np.random.default_rng(seed)
    trunk = [(0, 0, 0), (0.05, 1.0, 0.03), (-0.02, 2.2, 0.05), (0.05, height - 1.4, 0)]
    site.put(lathe([(0.15, 1.1), (0.18, 0.4), (0.3, 0.0)], 12), p.bark)
    site.put(tube(trunk, 0.13, 9), p.bark)
    site.put(lathe([(0, 0.03), (0.9, 0.03)], 20), p.earth)
    site.put(lathe([(0.9, 0.1), (1.05, 0.1), (1.08, 0.0)], 20), p.stone)
    for k in range(9):
        angle, reach = k * 2.4, 1.0 + 0.5 * rng.random()
        tip = (reach * np.sin(angle), height - 1.6 + 0.2 * k, reach * np.cos(angle))
        site.put(beam((0, 2.0 + 0.2 * k, 0), tip, 0.05), p.bark)
    cards = []
    for k in range(290):
        out = rng.normal(size=3)
        out /= np.linalg.norm(out)
        centre = out * np.array([1.75, 1.5, 1.75]) * rng.uniform(0.45, 1.0) + (0, height - 0.9, 0)
        size = rng.uniform(0.7, 1.05)
        card = quad((-size / 2, size / 2, 0), (size, 0, 0), (0, -size, 0)).map_uv(
            (1.1, 1.1), (k * 0.37 % 1, k * 0.61 % 1)
        )
        card = card.transform(
            rotation((0, 1, 0), np.arctan2(out[0], out[2]) + rng.uniform(-0.7, 0.7))
            @ rotation((1, 0, 0), rng.uniform(-1.2, 0.5))
        )
        # Normals of a round crown: it is lit as a whole.
        cards.append(
            Shape(card.positions + centre, np.broadcast_to(out, card.positions.shape), card.uv, card.triangles)
        )
    site.put(join(cards), p.leaves)


def monument(site: Site, p: Palette) -> None:
    """Add steps, an inscribed plinth and an obelisk with a ball."""
    for wide, y in ((3.0, 0.09), (2.4, 0.27), (1.8, 0.45)):
        site.put(box((wide, 0.18, wide), (0, y, 0)), p.stone)
    site.put(box((1.1, 1.0, 1.1), (0, 1.04, 0)), p.stone, (0.9, 0.86, 0.8))
    site.put(
        join(
            [
                box((1.34, 0.12, 1.34), (0, 0.6, 0)),
                box((1.3, 0.14, 1.3), (0, 1.6, 0)),
                box((1.0, 0.1, 1.0), (0, 1.72, 0)),
            ]
        ),
        p.stone,
    )
    sides = box((1.14, 0.142, 1.14), (0, 1.36, 0), ("front", "back", "left", "right"), True)
    site.put(sides, p.plinth)
    site.put(quad((-0.4, 1.26, 0.56), (0.8, 0, 0), (0, -0.56, 0)), p.notice)
    spire = join([frustum(0.34, 0.2, 1.77, 4.7), frustum(0.2, 0.02, 4.7, 5.05)])
    site.put(spire, p.stone, (0.86, 0.84, 0.8))
    site.put(sphere(0.16, 14).shift(0, 5.14, 0), p.stone)


def easel(site: Site, p: Palette, material: int, color: Color = WHITE) -> None:
    """Add an A-board on the pavement."""
    face = quad((-0.32, 1.02, 0.0), (0.64, 0, 0), (0, -0.92, 0.0))
    for turn in (0, 180):
        lean = rotation((1, 0, 0), -0.22)
        site.put(face.shift(0, 0, 0.016).transform(lean).shift(0, 0, 0.24).turn_y(turn), material, color)
        site.put(box((0.7, 1.06, 0.03), (0, 0.53, 0)).transform(lean).shift(0, 0, 0.24).turn_y(turn), p.wood)
