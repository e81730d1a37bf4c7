"""Static parts of the airstrip: ground, hangars, terminal, containers, grandstand, fences, trees, the infield."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from supersampling.scenes.airstrip.materials import Paints
from supersampling.scenes.airstrip.shapes import ring_band, upright, wing
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.furniture import barrel, crate, fence, sign
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, lathe, quad, tube
from supersampling.scenes.kit.skins import outline, skin

HALF_X, HALF_Z = 50.0, 36.0
ISLAND, APRON = (13.5, 6.2), (33.0, 21.0)  # half axes of the infield and of the tarmac's outer edge


def ground(b: Builder, p: Paints) -> None:
    """Add the infield, a ring of tarmac with its lines, grass and concrete around."""
    inner, outer = outline(*ISLAND), outline(*APRON)
    lawn = np.stack([inner * s for s in (1.0, 0.5, 0.02)])
    for a, c in pairwise(lawn):
        b.put(ring_band(a, c), p.grass)
    b.put(ring_band(outer, inner), p.tarmac)
    border = outline(HALF_X, HALF_Z, power=0.12)
    b.put(ring_band(border, outer), p.grass, (0.92, 0.95, 0.85))
    for share, width in ((0.0, 0.3), (0.42, 0.15), (1.0, 0.3)):
        axes = [i + share * (o - i) for i, o in zip(ISLAND, APRON)]
        line = ring_band(outline(axes[0] + width, axes[1] + width), outline(axes[0], axes[1]), 0.012)
        b.put(line, p.white)
    for x in np.arange(-6.0, 7.0, 1.5):
        b.put(box((0.7, 0.012, 5.0), (x, 0.006, -15.6), ("top",)), p.white)
        b.put(box((0.7, 0.012, 3.6), (x, 0.006, 16.4), ("top",)), p.white)
    for x in (-22.0, 0.0, 22.0):
        b.put(box((17.0, 0.05, 4.6), (x, 0.025, -22.9), ("top", "front", "left", "right")), p.slabs)
    b.put(box((60.0, 0.08, 4.0), (0, 0.04, 25.0), ("top", "back", "left", "right")), p.slabs)


def hangar(width: float, height: float, depth: float) -> tuple[Shape, Shape, Shape, Shape]:
    """Return the front (uv from 0 to 1), vaulted roof, side walls and frame; it looks along +z from z = 0."""
    x = np.linspace(-width / 2, width / 2, 33)
    eaves = height * 0.5
    arc = eaves + (height - eaves) * np.sqrt(np.clip(1 - (2 * x / width) ** 2, 0, 1))
    top = np.stack([x, arc, 0 * x], 1)
    foot = np.stack([x, 0 * x, 0 * x], 1)
    share = x / width + 0.5
    uv = np.stack([np.stack([share, 1 - arc / height], 1), np.stack([share, 0 * x + 1], 1)])
    front = skin(np.stack([top, foot]), uv)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(top, axis=0), axis=1))])
    back = top - np.array([0, 0, depth])
    metric = np.stack([np.stack([along, 0 * along + v], 1) for v in (0.0, depth)])
    roof = skin(np.stack([back, top]), metric).shift(0, 0.05, 0.3)
    walls = [box((0.3, eaves, depth), (s * (width / 2 - 0.14), eaves / 2, -depth / 2)) for s in (-1, 1)]
    line = top + np.array([0, 0, 0.12])
    frame = [tube(line, 0.14, 8)]
    frame += [beam((s * width / 2, 0, 0.12), (s * width / 2, eaves, 0.12), 0.3) for s in (-1, 1)]
    frame += [beam((-width / 2, y, 0.1), (width / 2, y, 0.1), 0.14) for y in (0.1, eaves - 0.9)]
    frame += [beam((u, 0.1, 0.07), (u, eaves - 0.9, 0.07), 0.1) for u in np.linspace(-width / 2, width / 2, 9)[1:-1]]
    frame += [box((0.5, 0.3, 0.4), (u, eaves - 1.2, 0.25)) for u in np.linspace(-width / 3, width / 3, 4)]
    return front, roof, join(walls), join(frame)


def hangars(b: Builder, p: Paints) -> None:
    """Add three painted hangars in the north, brick links between them."""
    for k, x in enumerate((-22.0, 0.0, 22.0)):
        front, roof, walls, frame = hangar(17.0, 9.6 + 0.5 * (k == 1), 9.0)
        for shape, material in ((front, p.murals[k]), (roof, p.roof), (walls, p.brick), (frame, p.iron)):
            b.put(shape.shift(x, 0, -25.4), material)
        for s in (-1, 1):
            b.put(barrel((x + s * 9.3, 0, -24.6)), p.cone)
            b.put(crate(0.9, 3 * k + s + 5).turn_y(12 * s).shift(x + s * 10.4, 0.45, -24.4), p.crates)
    for k, x in enumerate((-11.0, 11.0)):
        b.put(box((5.4, 5.6, 6.0), (x, 2.8, -29.5)), p.brick)
        b.put(box((5.6, 0.2, 6.2), (x, 5.7, -29.5)), p.slabs)
        _windows(b, p, [(x + u, 3.9) for u in (-1.6, 0.0, 1.6)], -26.5, 1)
        b.put(sign((x, 1.7, -26.5), 1.8, 1.8, "+z"), p.notices[k])
    for s in (-1, 1):
        b.put(box((16.0, 4.0, 0.4), (s * 39.0, 2.0, -28.0)), p.brick)
        for k in range(3):
            b.put(sign((s * 39.0 - 4.6 + 4.6 * k, 2.1, -27.8), 3.0, 3.0, "+z"), p.boards[(k + s) % 4])


def _windows(b: Builder, p: Paints, places: list[tuple[float, float]], z: float, out: int) -> None:
    """Add windows 1.3 x 1.6 m with bars and sills in a wall at ``z`` that looks along ``out``."""
    turn = 0 if out > 0 else 180
    pane = quad((-0.65, 0.8, 0.03), (1.3, 0, 0), (0, -1.6, 0))
    bars = [box((0.08, 1.7, 0.1), (u, 0, 0.05)) for u in (-0.67, 0.67)] + [box((0.05, 1.6, 0.06), (0, 0, 0.05))]
    bars += [box((1.42, 0.07, 0.1), (0, y, 0.05)) for y in (-0.8, -0.27, 0.27, 0.8)]
    for x, y in places:
        b.put(pane.turn_y(turn).shift(x, y, z), p.glass)
        b.put(join(bars).turn_y(turn).shift(x, y, z), p.white)
        b.put(box((1.7, 0.12, 0.3), (0, -0.9, 0.12)).turn_y(turn).shift(x, y, z), p.slabs)


def terminal(b: Builder, p: Paints) -> None:
    """Add a brick terminal in the south with a tower; its front is the plane z = 27."""
    b.put(box((54, 7.0, 6.0), (0, 3.5, 30.0), ("back", "left", "right", "top")), p.brick)
    for y, deep in ((0.5, 0.12), (3.7, 0.16), (7.0, 0.36)):
        b.put(box((54.4, 0.3, deep), (0, y, 27.0 - deep / 2 + 0.02)), p.slabs)
    xs = [x for x in np.arange(-25.5, 26.0, 3.0) if abs(x) > 3.2]
    _windows(b, p, [(x, y) for x in xs for y in (2.2, 5.3)], 27.0, -1)
    b.put(box((6.0, 12.0, 5.0), (0, 6.0, 28.8), ("back", "left", "right", "top")), p.brick, (0.85, 0.85, 0.9))
    b.put(box((7.4, 0.3, 6.2), (0, 10.0, 28.4)), p.slabs)
    for x in np.linspace(-3.6, 3.6, 13):
        b.put(beam((x, 10.1, 25.4), (x, 11.1, 25.4), 0.05), p.iron)
    b.put(beam((-3.6, 11.1, 25.4), (3.6, 11.1, 25.4), 0.07), p.iron)
    _windows(b, p, [(x, y) for x in (-1.6, 0.0, 1.6) for y in (5.4, 8.2)], 26.3, -1)
    for k, x in enumerate((-20.0, -8.0, 8.0, 20.0)):
        b.put(sign((x, 9.0, 27.2), 3.2, 3.2, "-z"), p.boards[k])
        for s in (-1.2, 1.2):
            b.put(beam((x + s, 7.0, 27.4), (x + s, 10.6, 27.4), 0.12), p.iron)
    b.put(sign((0, 2.2, 26.3), 2.4, 2.4, "-z"), p.notices[1])
    for x in (-24.0, -12.0, 12.0, 24.0):
        mesh, frame = fence((x - 5.9, 0, 23.6), (x + 5.9, 0, 23.6), 1.7)
        b.put(mesh, p.fence)
        b.put(frame, p.iron)


def ends(b: Builder, p: Paints) -> None:
    """Add containers stacked in the west, a grandstand in the east."""
    rng = np.random.default_rng(8)
    unit = box((6.0, 2.6, 2.4), (0, 1.3, 0), fit=True)
    for row in range(5):
        for level in range(3 - (row % 2)):
            k, turn = int(rng.integers(8)), 90 + float(rng.uniform(-3, 3))
            cell = unit.map_uv((0.5, 0.25), (k % 2 * 0.5, k // 2 * 0.25))
            place = cell.turn_y(turn).shift(-41.5 + rng.uniform(-0.3, 0.3), 2.6 * level, -13.6 + 6.8 * row)
            b.put(place, p.containers)
    for k in range(8):
        b.put(box((1.0, 0.12, 34.0), (38.5 + k, 0.6 + 0.55 * k, 0)), p.wood)
        b.put(box((0.06, 0.5, 34.0), (38.05 + k, 0.3 + 0.55 * k, 0)), p.wood, (0.75, 0.72, 0.7))
    for z in np.arange(-16.5, 17.0, 3.0):
        b.put(beam((38.2, 0.1, z), (45.8, 4.3, z), 0.12), p.iron)
        b.put(beam((45.9, 0, z), (45.9, 7.6, z), 0.16), p.iron)
        b.put(beam((45.9, 7.6, z), (40.5, 7.2, z), 0.1), p.iron)
    b.put(box((6.0, 0.1, 35.0), (43.2, 7.5, 0)), p.roof)
    for k, z in enumerate(np.arange(-15.0, 16.0, 3.0)):
        b.put(sign((37.6, 0.75, z), 2.8, 1.4, "-x"), p.boards[k % 4])
        b.put(box((0.05, 1.4, 2.9), (37.6, 0.75, z)), p.wood)
    for z in np.arange(-16.0, 16.1, 0.8):
        if rng.random() < 0.8:
            row = int(rng.integers(7))
            shade = tuple(float(c) for c in rng.uniform(0.35, 1.0, 3))
            coat = lathe([(0.0, 0.95), (0.1, 0.93), (0.12, 0.8), (0.06, 0.74), (0.22, 0.66), (0.2, 0.1), (0.0, 0.1)], 8)
            b.put(coat.shift(38.6 + row, 0.62 + 0.55 * row, z), p.white, (shade[0], shade[1], shade[2]))


def trees(b: Builder, p: Paints) -> None:
    """Add cards of leaves behind everything, and a low brick wall around."""
    rng = np.random.default_rng(5)
    for k in range(84):
        side = k % 4
        x, z = rng.uniform(-48, 48), rng.uniform(-34, 34)
        x, z = ((x, -35.0), (x, 34.8), (-48.0, z), (48.5, z))[side]
        size, turn = float(rng.uniform(5, 9)), float(rng.uniform(-25, 25)) + (0, 180, 90, -90)[side]
        tone = float(rng.uniform(0.6, 1.0))
        for j in range(2):
            card = quad((-size / 2, 2.0 + size, 0), (size, 0, 0), (0, -size, 0))
            b.put(card.turn_y(turn + 70 * j).shift(x, 0, z), p.leaves, (tone, tone, 0.9 * tone))
        b.put(cylinder(0.22, 4.0, 8).shift(x, 2.0, z), p.wood, (0.5, 0.5, 0.5))
    for s in (-1, 1):
        b.put(box((100, 2.4, 0.3), (0, 1.2, s * 35.8)), p.brick)
        b.put(box((0.3, 2.4, 72), (s * 49.8, 1.2, 0)), p.brick)


def infield(b: Builder, p: Paints) -> None:
    """Add grass tufts, timing scaffold, windsock's mast, cones, barrels and crates."""
    rng = np.random.default_rng(6)
    for _ in range(800):
        far = rng.random() < 0.35
        way, reach = rng.uniform(0, 2 * np.pi), 1.0 if not far else 0.0
        edge = ISLAND if not far else (APRON[0] + 1.2, APRON[1] + 0.8)
        share = np.sqrt(rng.uniform(0.2, 0.98)) if reach else rng.uniform(1.0, 1.05)
        x, z = edge[0] * share * np.cos(way) * 0.97, edge[1] * share * np.sin(way) * 0.97
        size = float(rng.uniform(0.16, 0.36))
        card = quad((-size / 2, size, 0), (size, 0, 0), (0, -size, 0))
        card = replace(card, normals=np.tile([0.0, 0.95, 0.3122], (4, 1)))  # lit nearly as the lawn is
        for turn in (0.0, 90.0, 180.0, 270.0):
            b.put(card.turn_y(turn + np.degrees(way)).shift(float(x), -0.01, float(z)), p.tufts)
    for x, z in ((-1.2, -0.8), (1.2, -0.8), (-1.2, 0.8), (1.2, 0.8)):
        b.put(beam((x, 0, z), (x, 4.4, z), 0.08), p.iron)
    for y in (0.3, 1.4, 2.5, 3.4):
        for s in (-1, 1):
            b.put(beam((-1.2, y, s * 0.8), (1.2, y, s * 0.8), 0.05), p.iron)
            b.put(beam((s * 1.2, y, -0.8), (s * 1.2, y + 1.0, 0.8), 0.04), p.iron)
    b.put(box((2.7, 0.08, 1.9), (0, 3.4, 0)), p.wood)
    for k, s in enumerate((1, -1)):
        board = quad((-1.3, 5.0, 0.9), (2.6, 0, 0), (0, -1.5, 0)).turn_y(180 * k)
        b.put(board, p.notices[k])
        b.put(box((2.7, 1.6, 0.05), (0, 4.25, 0.86 * s)), p.iron)
    pylon = lathe([(0.12, 4.2), (0.3, 3.9), (0.75, 0.1), (0.8, 0.0)], 24).map_uv((0.5, 0.25))
    for x, z in ((-13.6, 0.0), (13.6, 0.0)):
        b.put(pylon.shift(x, 0, z), p.cone)
    small = join([lathe([(0.04, 0.72), (0.16, 0.05)], 16).map_uv((1, 1.4)), box((0.4, 0.05, 0.4), (0, 0.025, 0))])
    for t in np.arange(0.2, 6.3, 0.48):
        b.put(small.shift(13.9 * np.cos(t), 0, 6.55 * np.sin(t)), p.cone)
    for k, (x, z) in enumerate(((-4.0, 0.3), (-4.6, -0.3), (4.4, 0.2), (5.0, -0.5), (4.2, -0.6))):
        b.put(barrel((x, 0, z)), (p.cone, p.roof)[k % 2])
    for k, (x, z) in enumerate(((-3.1, -0.2), (3.3, 0.4), (3.2, -0.5), (-8.6, 0.1))):
        b.put(crate(0.7, 2 * k).turn_y(17 * k).shift(x, 0.35, z), p.crates)
    b.put(cylinder(0.06, 6.0, 10).shift(8.0, 3.0, 0.0), p.white)
    b.put(box((0.8, 0.2, 0.8), (8.0, 0.1, 0.0)), p.slabs)
    spare = np.array([[-1.6, 0, 0.4, 0.7, 0.08], [0.0, 0, 0.5, 1.1, 0.14], [1.6, 0, 0.4, 0.7, 0.08]])
    b.put(upright(wing(spare)).shift(-8.0, 1.6, -0.6), p.liveries[1])


def field(b: Builder, p: Paints) -> None:
    for part in (ground, hangars, terminal, ends, trees, infield):
        part(b, p)
