"""Painted walls and laid floors of the sundial court: colour and small relief without depth."""

import numpy as np

from supersampling.scenes.kit import textures
from supersampling.scenes.kit.textures import Field, Maps, fractal, normals, picture, ramp, surface

_LIME = np.array([0.93, 0.91, 0.86])
_SIENNA, _OCHRE = np.array([0.62, 0.29, 0.19]), np.array([0.8, 0.58, 0.28])
_BLUE, _CREAM = np.array([0.2, 0.33, 0.55]), np.array([0.92, 0.88, 0.78])


def limewash(size: int, seed: int) -> tuple[Field, Field]:
    """Return the brightness (about 0.9) and the height of a trowelled wall that tiles."""
    grain, cloud, stroke = (
        fractal(size, seed, 0.4),
        fractal(size, seed + 1, 1.3),
        fractal(size, seed + 2, 0.8, (1.0, 2.5)),
    )
    chip = np.clip((fractal(size, seed + 3, 1.0) - 0.86) * 14, 0, 1)
    bright = 0.94 + 0.1 * (cloud - 0.5) + 0.1 * (grain - 0.5) + 0.08 * (stroke - 0.5) - 0.14 * chip
    return bright, 0.5 * grain + 0.7 * stroke - 0.6 * chip


def wall(size: int, seed: int) -> Maps:
    """Draw bare lime wash."""
    bright, height = limewash(size, seed)
    return picture(bright[..., None] * _LIME), normals(height, 3.5), surface(0.85 + 0.1 * height)


def arcade(size: int, seed: int, variant: int) -> Maps:
    """Draw one bay of a painted arcade: pilasters, an arch of two colours, and in it a lattice of vines or a sky."""
    y, x = np.mgrid[:size, :size] / size
    u = x - 0.5
    bright, height = limewash(size, seed)
    color = np.broadcast_to(_LIME, (size, size, 3)).copy()
    spring, radius = 0.4, 0.34
    from_middle, angle = np.hypot(u, (y - spring) * 1.25), np.arctan2(spring - y, u)
    opening = np.where(y < spring, from_middle < radius, np.abs(u) < radius)
    ring = (y < spring) & (from_middle >= radius) & (from_middle < radius + 0.075)
    stone = np.floor(angle / np.pi * 13).astype(int) % 2 == 0
    color[ring] = np.where(stone[..., None], _SIENNA, _CREAM)[ring]
    joint = np.abs((angle / np.pi * 13) % 1) < 0.06
    color[ring & joint] *= 0.72
    pilaster = (np.abs(u) > 0.415) & (y > 0.06)
    color[pilaster] = _OCHRE * 1.08
    flute = np.abs(((np.abs(u) - 0.415) / 0.085 * 4) % 1 - 0.5) < 0.14
    color[pilaster & flute & (y > 0.16) & (y < 0.92)] *= 0.74
    for top, bottom, reach, tone in (
        (0.0, 0.035, 0.5, 0.95),
        (0.035, 0.06, 0.5, 0.7),
        (0.095, 0.15, 0.11, 0.9),
        (0.94, 1.0, 0.12, 0.82),
    ):
        band = (y >= top) & (y < bottom) & (0.5 - np.abs(u) < reach)
        color[band] = _SIENNA * tone * 1.1
    if variant == 0:
        sky = ramp(np.clip(y / 0.95, 0, 1), [(0.36, 0.52, 0.74), (0.62, 0.72, 0.8), (0.86, 0.82, 0.7)])
        hill = y > 0.66 + 0.05 * np.sin(7 * x + seed) + 0.02 * np.sin(23 * x)
        sky[hill] = ramp(fractal(size, seed + 5, 1.0), [(0.3, 0.38, 0.24), (0.5, 0.53, 0.32)])[hill]
        for c in (-0.17, 0.14):
            tree = (np.abs(u - c) < 0.05 * np.clip((y - 0.34) * 4, 0, 1) ** 0.7) & (y < 0.84)
            sky[tree] = ramp(fractal(size, seed + 6, 0.5), [(0.1, 0.2, 0.12), (0.26, 0.36, 0.2)])[tree]
        color[opening] = sky[opening]
    else:
        weave = (np.abs(((x + y) * 15) % 1 - 0.5) < 0.09) | (np.abs(((x - y) * 15) % 1 - 0.5) < 0.09)
        color[opening] = np.where(weave[..., None], _OCHRE * 0.75, np.array([0.78, 0.8, 0.7]))[opening]
        vine = textures.foliage(size, seed, 150, [(0.16, 0.26, 0.1), (0.36, 0.46, 0.2), (0.6, 0.62, 0.3)])
        leafy = opening & (vine[..., 3] > 0) & (fractal(size, seed + 7, 1.1) + 0.5 * np.abs(u) > 0.62)
        color[leafy] = vine[leafy][:, :3] / 255
    sill = opening & (y > 0.9)
    color[sill] = _CREAM * 0.86
    line = np.abs(np.where(y < spring, from_middle, np.abs(u)) - radius) < 0.006
    color[line & (y < 0.94)] = _SIENNA * 0.55
    worn = np.clip((fractal(size, seed + 8, 1.0) - 0.72) * 6, 0, 0.8)[..., None]
    color = color + worn * (_LIME - color)
    return picture(color * bright[..., None]), normals(height, 3.0), surface(0.85 + 0.1 * height)


def glazed_dado(size: int, seed: int, cells: int = 4) -> Maps:
    """Draw painted wall tiles, matt: stars and quarter circles in blue and ochre on cream, tones vary by tile."""
    inside, value, height = textures.masonry(size, cells, cells, 0.006, seed, 0.0)
    y, x = np.mgrid[:size, :size] / size * cells
    u, v = x % 1 - 0.5, y % 1 - 0.5
    corner = np.hypot(0.5 - np.abs(u), 0.5 - np.abs(v))
    star = np.abs(u) + np.abs(v) < 0.2 + 0.1 * np.cos(4 * np.arctan2(v, u)) ** 2
    color = np.broadcast_to(_CREAM, (size, size, 3)).copy()
    color[(corner < 0.42) & (corner > 0.34)] = _BLUE
    color[corner < 0.24] = _OCHRE
    color[corner < 0.12] = _BLUE * 0.7
    color[star] = _BLUE
    color[np.hypot(u, v) < 0.09] = _CREAM
    grain = fractal(size, seed + 3, 0.5)
    tone = (0.86 + 0.2 * (value - 0.5) + 0.14 * (grain - 0.5))[..., None]
    color = np.where(inside[..., None] > 0.5, color * tone, np.array([0.55, 0.52, 0.46]))
    return picture(color), normals(height + 0.1 * grain, 3.0), surface(0.7 + 0.15 * grain)


def meander(size: int, seed: int) -> Maps:
    """Draw a painted frieze, one picture per square: a key pattern between two lines."""
    pattern = (
        "111111111111",
        "000000000000",
        "111111111110",
        "100000000010",
        "101111111010",
        "101000001010",
        "101011101010",
        "101010001010",
        "101011111010",
        "101000000011",
        "000000000000",
        "111111111111",
    )
    key = np.array([[int(c) for c in row] for row in pattern])
    index = np.arange(size) * len(key) // size
    painted = key[np.ix_(index, index)].astype(float)
    bright, height = limewash(size, seed)
    color = np.where(painted[..., None] > 0, _SIENNA, _LIME)
    return picture(color * bright[..., None]), normals(height, 3.0), surface(0.85 + 0.1 * height)


def paving(size: int, seed: int, count: int = 4) -> Maps:
    """Draw pale limestone squares with small dark insets at their corners, worn and dusty."""
    inside, value, height = textures.masonry(size, count, count, 0.004, seed, 0.0)
    y, x = np.mgrid[:size, :size] / size * count
    inset = np.maximum(0.5 - np.abs(x % 1 - 0.5), 0.5 - np.abs(y % 1 - 0.5))
    corner = (0.5 - np.abs(x % 1 - 0.5)) + (0.5 - np.abs(y % 1 - 0.5)) < 0.2
    grain, cloud, vein = (fractal(size, seed + 1, 0.4), fractal(size, seed + 2, 1.2), fractal(size, seed + 3, 1.1))
    tone = np.clip(0.5 + 0.5 * (value - 0.5) + 0.4 * (cloud - 0.5) + 0.5 * (grain - 0.5), 0, 1)
    color = ramp(tone, [(0.62, 0.58, 0.5), (0.8, 0.76, 0.68), (0.9, 0.87, 0.8)])
    color *= (1 - 0.2 * np.clip(1 - np.abs(vein - 0.5) * 40, 0, 1))[..., None]
    color[corner] = ramp(grain, [(0.3, 0.17, 0.12), (0.52, 0.3, 0.21)])[corner]
    color = np.where(inside[..., None] > 0.5, color, 0.4)
    return (picture(color), normals(height + 0.2 * grain + 0.1 * (inset > 0.2), 3.0), surface(0.72 + 0.2 * grain))


def stucco(size: int, seed: int) -> Maps:
    """Draw the warm red plaster of the lamp chamber with a stencilled lozenge pattern."""
    y, x = np.mgrid[:size, :size] / size * 4
    lozenge = np.abs(x % 1 - 0.5) + np.abs(y % 1 - 0.5)
    bright, height = limewash(size, seed)
    color = np.broadcast_to(np.array([0.7, 0.42, 0.29]), (size, size, 3)).copy()
    color[(lozenge > 0.4) & (lozenge < 0.46)] = (0.83, 0.62, 0.36)
    color[lozenge < 0.1] = (0.83, 0.62, 0.36)
    worn = np.clip((fractal(size, seed + 4, 1.0) - 0.66) * 5, 0, 0.7)[..., None]
    color = color + worn * (np.array([0.74, 0.52, 0.4]) - color)
    return picture(color * bright[..., None] ** 2), normals(height, 3.5), surface(0.85 + 0.1 * height)
