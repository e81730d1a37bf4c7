"""Smooth skins for the airstrip: fuselages, wings and their like. Metres; each function describes its uv."""

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Floats, Shape, box, grid, join, lathe
from supersampling.scenes.kit.skins import skin


def hull(stations: ArrayLike, rows: int = 13) -> Shape:
    """Return a body along x of elliptic sections ``stations (S, 4)``.

    A station is x (ascending), the middle's y, half height and half width (both positive).
    uv run from 0 to 1 along the body and from top to bottom, v in the upper half for the right side (+z) and in the
    lower half for the left one; u runs to the right as seen from outside, so that lettering can be read on both.
    """
    s = np.asarray(stations, float)
    angle = np.linspace(0, np.pi, rows)[:, None]
    share = (s[:, 0] - s[0, 0]) / (s[-1, 0] - s[0, 0])
    low, high = (s[:, 1] - s[:, 2]).min(), (s[:, 1] + s[:, 2]).max()
    sides = []
    for side in (1, -1):
        line = s[::side]
        y = line[:, 1] + line[:, 2] * np.cos(angle)
        points = np.stack(np.broadcast_arrays(line[:, 0], y, side * line[:, 3] * np.sin(angle)), -1)
        u = share if side > 0 else (1 - share)[::-1]
        v = (high - y) / (high - low) / 2 + (side < 0) / 2
        sides.append(skin(points, np.stack(np.broadcast_arrays(u, v), -1)))
    return join(sides)


def wing(ribs: ArrayLike, rows: int = 9) -> Shape:
    """Return a wing across ``ribs (N, 5)``: z ascending, y, leading edge's x, chord, thickness (positive).

    uv run from 0 to 1, v aft.
    """
    ribs = np.asarray(ribs, float)
    share = (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, rows)))[:, None]
    profile = 2.6 * (np.sqrt(share) - share) * 0.5 + 0.02 * (1 - share)
    u = (ribs[:, 0] - ribs[0, 0]) / (ribs[-1, 0] - ribs[0, 0])
    faces = []
    for side in (1, -1):
        r = ribs[::side]
        x = r[:, 2] - share * r[:, 3]
        points = np.stack(np.broadcast_arrays(x, r[:, 1] + side * profile * r[:, 4], r[:, 0]), -1)
        across = u if side > 0 else (1 - u)[::-1]
        faces.append(skin(points, np.stack(np.broadcast_arrays(across, 0.5 + share / 2), -1)))
    return join(faces)


def upright(shape: Shape) -> Shape:
    """Turn a wing so that it stands: its span, +z, goes up."""
    return shape.transform(rotation((1, 0, 0), -np.pi / 2))


def propeller(radius: float, blades: int) -> Shape:
    """Return blades about the x axis, thinner and flatter towards their tips, and a spinner that looks along +x."""
    share = np.linspace(0, 1, 6)
    parts = [lathe([(0.0, 0.34), (0.07, 0.3), (0.13, 0.18), (0.16, 0.0), (0.0, -0.02)], 20)]
    parts = [parts[0].transform(rotation((0, 0, 1), -np.pi / 2))]
    for k in range(blades):
        ribs = np.stack(
            [
                0.1 + share * (radius - 0.1),
                0 * share,
                0.09 - 0.03 * share,
                0.19 - 0.09 * share**2,
                0.05 - 0.035 * share,
            ],
            1,
        )
        blade = wing(ribs, 7).transform(rotation((0, 0, 1), np.radians(62)))
        parts.append(blade.transform(rotation((1, 0, 0), 2 * np.pi * k / blades)))
    return join(parts)


def ring_band(outer: Floats, inner: Floats, y: float = 0.0) -> Shape:
    """Return a flat ring on the ground between two closed outlines ``(N, 2)`` of (x, z) that run from +x towards -z."""
    lines = np.stack([outer, inner])
    lines = np.concatenate([lines, lines[:, :1]], axis=1)
    points = np.stack([lines[..., 0], np.full(lines.shape[:2], y), lines[..., 1]], -1)
    up = np.broadcast_to([0.0, 1.0, 0.0], points.shape)
    return grid(points[:, ::-1], up, lines[:, ::-1])


def wheel(radius: float, width: float) -> Shape:
    """Return a tyre and hub about the z axis."""
    half = width / 2
    tyre = [(0.0, half * 0.7), (0.5, half * 0.7), (0.55, half), (0.9, half), (1.0, half * 0.6)]
    tyre += [(1.0, -half * 0.6), (0.9, -half), (0.55, -half), (0.5, -half * 0.7), (0.0, -half * 0.7)]
    shape = lathe([(r * radius, y) for r, y in tyre], 20).transform(rotation((1, 0, 0), np.pi / 2))
    bolts = [
        box((0.1 * radius, 0.1 * radius, width * 0.8), (0.32 * radius, 0, 0)).transform(rotation((0, 0, 1), a))
        for a in np.arange(5) * 2 * np.pi / 5
    ]
    return join([shape, *bolts])
