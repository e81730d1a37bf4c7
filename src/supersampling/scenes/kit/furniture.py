"""Things that stand about in several scenes: crates, drums, fences, signs, framed pictures and bookcases."""

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.shapes import ALL, Shape, atlas_cell, beam, box, join, lathe, panel, quad


def crate(size: float, cell: int) -> Shape:
    """Return a cube about the origin whose faces show one cell of a `lettering.label_sheet`."""
    faces = [f for f in ALL if f != "bottom"]
    return box((size,) * 3, faces=faces, fit=True).map_uv(*atlas_cell(4, 4, cell))


def barrel(foot: ArrayLike) -> Shape:
    """Return a steel drum that stands at ``foot``, 0.9 m high, with two hoops."""
    x, y, z = np.asarray(foot, float)
    profile = [(0, 0.87), (0.27, 0.87), (0.29, 0.9), (0.3, 0.88), (0.3, 0.62), (0.325, 0.6), (0.3, 0.58)]
    profile += [(0.3, 0.32), (0.325, 0.3), (0.3, 0.28), (0.3, 0.0)]
    return lathe(profile, 32).shift(x, y, z)


def fence(a: ArrayLike, b: ArrayLike, height: float) -> tuple[Shape, Shape]:
    """Return the alpha-tested mesh and the frame of a fence between two feet."""
    start, end = np.asarray(a, float), np.asarray(b, float)
    up = np.array([0.0, height, 0.0])
    low = np.array([0.0, 0.12, 0.0])
    count = max(round(float(np.linalg.norm(end - start)) / 1.4), 1)
    frame = [
        beam(start + share * (end - start), start + share * (end - start) + up, 0.05)
        for share in np.linspace(0, 1, count + 1)
    ]
    for lift in (up, low, up * 0.52):
        frame.append(beam(start + lift, end + lift, 0.035))
    return panel(start + up, end - start, low - up, (2, count)), join(frame)


def sign(position: ArrayLike, width: float, height: float, facing: str) -> Shape:
    """Return a picture 3 cm in front of a wall, its middle at ``position``; uv run from 0 to 1.

    ``facing`` is the axis along which it looks.
    """
    right = {"+z": (1, 0, 0), "-z": (-1, 0, 0), "+x": (0, 0, -1), "-x": (0, 0, 1)}[facing]
    out = np.cross(right, (0, 1, 0))
    corner = np.asarray(position, float) + 0.03 * out - 0.5 * width * np.array(right) + np.array([0, height / 2, 0])
    return quad(corner, np.multiply(right, width), (0, -height, 0))


def framed_picture(width: float, height: float) -> tuple[Shape, Shape]:
    """Return a picture of this size, its middle at the origin against a wall at z = 0, and its frame."""
    picture = quad((-width / 2, height / 2, 0.03), (width, 0, 0), (0, -height, 0))
    bars = [box((0.05, height + 0.1, 0.05), (side * (width / 2 + 0.025), 0, 0.025)) for side in (-1, 1)]
    bars += [box((width, 0.05, 0.05), (0, side * (height / 2 + 0.025), 0.025)) for side in (-1, 1)]
    return picture, join(bars)


def bookcase(rng: np.random.Generator, width: float = 2.3, shelves: int = 7) -> tuple[Shape, Shape]:
    """Return a wooden case against a wall at z = 0, and its books, whose uv point into the atlas of spines (16 x 4)."""
    pitch, depth = 0.38, 0.36
    top = shelves * pitch + 0.12
    wood = [box((0.06, top, depth), (side * (width / 2 + 0.03), top / 2, depth / 2)) for side in (-1, 1)]
    wood += [box((width, 0.035, depth), (0, 0.1 + k * pitch, depth / 2)) for k in range(shelves + 1)]
    wood += [
        box((width, top, 0.02), (0, top / 2, 0.01)),
        box((width + 0.24, 0.09, depth + 0.08), (0, top + 0.04, depth / 2)),
    ]
    unit = box((1, 1, 1), faces=("front", "left", "right", "top"), fit=True)
    scale = np.where(np.arange(16)[:, None] < 4, 1.0, 0.12)  # covers repeat the spine's corner
    books = []
    for k in range(shelves):
        x = -width / 2 + 0.01
        while x < width / 2 - 0.08:
            thick, tall, deep = rng.uniform(0.028, 0.07), rng.uniform(0.23, 0.33), rng.uniform(0.2, 0.29)
            middle = [x + thick / 2, 0.118 + k * pitch + tall / 2, deep / 2 + 0.03]
            cell = rng.integers(64)
            positions = unit.positions * [thick - 0.003, tall, deep] + middle
            books.append(
                Shape(positions, unit.normals, (unit.uv * scale + [cell % 16, cell // 16]) / [16, 4], unit.triangles)
            )
            x += thick + (rng.uniform(0.05, 0.2) if rng.random() < 0.06 else 0)
    return join(wood), join(books)
