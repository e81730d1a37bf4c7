"""Parts that turn and swing above the court, each about its own origin: only their shadows are visible."""

import numpy as np

from supersampling.scenes.kit.blocks import beam, box
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Floats, Shape, cylinder, grid, join, plate, tube


def slatted_wheel(radius: float, slats: int = 18) -> Shape:
    """Return a wheel about y: a rim, a hub, and flat slats that leave half of the light through."""
    circle = np.linspace(0, 2 * np.pi, 49)[:-1]
    rim = np.stack([np.cos(circle), np.sin(circle)], 1)
    flat = rotation((1, 0, 0), np.pi / 2)
    rings = [plate(rim * r, rim * (r - 0.16), 0.12, True).transform(flat) for r in (radius, radius * 0.58)]
    angles = np.arange(slats) * 2 * np.pi / slats
    blades = []
    for k, a in enumerate(angles):
        inner, outer = (0.3, radius - 0.1) if k % 3 == 0 else (radius * 0.55, radius - 0.1)
        blade = box((outer - inner, 0.06, 0.16 if k % 3 == 0 else 0.42), ((outer + inner) / 2, 0, 0))
        blades.append(blade.transform(rotation((0, 1, 0), a)))
    return join([*rings, *blades, cylinder(0.4, 0.3, 20)])


def lattice_drum(radius: float, length: float, strands: int = 12) -> Shape:
    """Return a drum about x: hoops, and strands that wind round it in both directions."""
    t = np.linspace(0, 1, 13)
    parts = []
    for sense in (-1, 1):
        for k in range(strands):
            angle = 2 * np.pi * k / strands + sense * np.pi * 0.8 * t
            line = np.stack([(t - 0.5) * length, radius * np.cos(angle), radius * np.sin(angle)], 1)
            parts.append(tube(line, 0.07, 5))
    circle = np.linspace(0, 2 * np.pi, 33)[:-1]
    for x in np.linspace(-length / 2, length / 2, 4):
        hoop = np.stack([0 * circle + x, radius * np.cos(circle), radius * np.sin(circle)], 1)
        parts.append(tube(hoop, 0.09, 6, True))
    return join([*parts, beam((-length / 2 - 0.5, 0, 0), (length / 2 + 0.5, 0, 0), 0.16)])


def sails(radius: float) -> tuple[Shape, Shape]:
    """Return four windmill sails about z: the laths and half-set canvas (both as closed boxes)."""
    wood, cloth = [cylinder(0.35, 0.7, 16).transform(rotation((1, 0, 0), np.pi / 2))], []
    for k in range(4):
        turn = rotation((0, 0, 1), k * np.pi / 2)
        laths = [box((0.2, radius, 0.2), (0, radius / 2, 0))]
        laths += [box((1.5, 0.07, 0.07), (0.55, y, 0.02)) for y in np.arange(1.3, radius, 0.42)]
        laths += [box((0.07, radius - 1.2, 0.07), (x, radius / 2 + 0.6, 0.02)) for x in (-0.2, 0.55, 1.3)]
        wood += [lath.transform(turn) for lath in laths]
        cloth.append(box((0.72, radius * 0.5, 0.02), (0.92, radius * 0.7, 0.08)).transform(turn))
    return join(wood), join(cloth)


def banner(width: float, height: float) -> Shape:
    """Return cloth that hangs from a bar along x at the origin, slightly bellied, with a swallow tail; both sides."""
    v, u = np.meshgrid(np.linspace(0, 1, 7), np.linspace(-1, 1, 9), indexing="ij")
    long = height * (1 - 0.22 * (1 - np.abs(u)) * v)
    points = np.stack([u * width / 2, -v * long, 0.14 * np.sin(np.pi * v) * (1 - u**2)], -1)
    normal = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    cloth = grid(points, normal, np.stack([(u + 1) / 2 * width, v * height], -1))
    return join([cloth, beam((-width / 2 - 0.1, 0.02, 0), (width / 2 + 0.1, 0.02, 0), 0.06)])


def pierced_shade(radius: float, height: float, columns: int = 24, rows: int = 6) -> Shape:
    """Return a drum about y with a closed lid; the cells of its sheet have holes, stars and rosettes in turn."""
    turn = np.linspace(0, 2 * np.pi, 33)
    square = np.stack([np.cos(turn), np.sin(turn)], 1)
    square /= 2 * np.abs(square).max(axis=1, keepdims=True)
    cells = []
    for row in range(rows):
        for column in range(columns):
            odd = (row + column) % 2
            reach = 0.3 + 0.09 * np.cos(6 * turn) if odd else 0.17 + 0.2 * np.abs(np.cos(2 * turn)) ** 3
            hole = np.stack([np.cos(turn), np.sin(turn)], 1) * reach[:, None]
            # Clockwise, so that the outside is the front.
            rings = np.stack([square, hole])[:, ::-1]
            a = (column + 0.5 + rings[..., 0]) / columns * 2 * np.pi
            y = (0.5 - (row + 0.5) / rows) * height + rings[..., 1] * height / rows
            normal = np.stack([np.sin(a), 0 * a, np.cos(a)], -1)
            points = normal * radius + np.stack([0 * a, y, 0 * a], -1)
            cells.append(grid(points, normal, np.stack([a * radius, -y], -1)))
    return join([*cells, _disc(radius, height / 2)])


def _disc(radius: float, y: float) -> Shape:
    angle = np.linspace(0, 2 * np.pi, 25)
    rim = np.stack([radius * np.sin(angle), 0 * angle + y, radius * np.cos(angle)], 1)
    rows = np.stack([np.broadcast_to([0.0, y, 0.0], rim.shape), rim])
    return grid(rows, np.broadcast_to([0.0, 1.0, 0.0], rows.shape), rows[..., (0, 2)])


def star_plate(radius: float, points: int = 8) -> Shape:
    """Return flat spokes about y that turn under a light."""
    blades: list[Shape] = []
    for k in range(points):
        a = 2 * np.pi * k / points
        corners: Floats = np.array(
            [(0.05, 0, 0.0), (radius * 0.6, 0, radius * 0.16), (radius, 0, 0), (radius * 0.6, 0, -radius * 0.16)]
        )
        flat = Shape(corners, np.tile([0.0, 1.0, 0.0], (4, 1)), corners[:, [0, 2]], np.array([[0, 1, 2], [0, 2, 3]]))
        blades.append(flat.transform(rotation((0, 1, 0), a)))
    return join(blades)
