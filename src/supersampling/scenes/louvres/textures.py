"""Matt textures of fine regular structure: stripes, checks, pinstripes, mosaic, pavers, timber, plaster and paint."""

from collections.abc import Sequence

import numpy as np

from supersampling.scenes.kit.textures import (
    Field,
    Maps,
    fractal,
    masonry,
    normals,
    photo,
    picture,
    ramp,
    resized,
    surface,
)
from supersampling.scenes.scene import Texture

Color = Sequence[float]
LEAST_ROUGHNESS = 0.6


def _weave(color: Field, seed: int) -> Texture:
    """Multiply the grain of threads and some fading into the colours of a cloth."""
    size = len(color)
    y, x = np.mgrid[:size, :size]
    thread = 0.92 + 0.08 * ((x // 2 + y // 2) % 2)
    return picture(color * (thread * (0.86 + 0.2 * fractal(size, seed, 1.1)))[..., None])


def stripes(size: int, count: int, colors: Sequence[Color], seed: int, share: float = 0.5) -> Texture:
    """Draw ``count`` upright stripes of the first colour, each a ``share`` of its period, on the second; cloth."""
    across = np.mgrid[:size, :size][1] / size * count % 1
    inked = np.clip((share / 2 - np.abs(across - 0.5)) * size / count + 0.5, 0, 1)[..., None]
    return _weave(inked * np.array(colors[0]) + (1 - inked) * np.array(colors[1]), seed)


def gingham(size: int, count: int, colors: Sequence[Color], seed: int) -> Texture:
    """Draw a check of ``count`` periods per side: two crossing sets of stripes, full in colour where they cross."""
    y, x = np.mgrid[:size, :size] / size * count
    amount = 0.5 * ((x % 1 < 0.5).astype(float) + (y % 1 < 0.5))
    return _weave(amount[..., None] * np.array(colors[0]) + (1 - amount[..., None]) * np.array(colors[1]), seed)


def mosaic(size: int, cells: int, colors: Sequence[Color], seed: int) -> Maps:
    """Draw small square tiles, chequered, each of its own shade."""
    inside, value, height = masonry(size, cells, cells, 0.15 / cells, seed, 0.0)
    y, x = np.mgrid[:size, :size] / size * cells
    odd = (np.floor(x) + np.floor(y)) % 2 > 0.5
    body = np.where(odd[..., None], colors[0], colors[1]) * (0.8 + 0.3 * value[..., None])
    color = inside[..., None] * body + (1 - inside[..., None]) * 0.6
    return picture(color), normals(height, 2.0), surface(LEAST_ROUGHNESS + 0.2 * (1 - inside))


def pavers(size: int, rows: int, columns: int, stops: Sequence[Color], seed: int) -> Maps:
    """Draw concrete pavers in running bond."""
    inside, value, height = masonry(size, rows, columns, 0.004, seed)
    grain, cloud = fractal(size, seed + 2, 0.3), fractal(size, seed + 3, 1.2)
    body = ramp(np.clip(0.5 * value + 0.3 * cloud + 0.2 * grain, 0, 1), stops) * (0.8 + 0.35 * grain[..., None])
    color = inside[..., None] * body + (1 - inside[..., None]) * 0.2
    return picture(color), normals(height + 0.15 * grain, 4.0), surface(0.75 + 0.2 * grain)


def timber(size: int, seed: int, stops: Sequence[Color]) -> Maps:
    """Draw oiled wood without joints, its grain along v, matt."""
    warp, fibre = fractal(size, seed, 1.5, (0.4, 2.0)), fractal(size, seed + 1, 0.5, (6.0, 1.0))
    cloud = fractal(size, seed + 2, 1.1)
    tone = 0.3 * (0.5 + 0.5 * np.sin(2 * np.pi * 6 * warp)) + 0.35 * fibre + 0.35 * cloud
    return (picture(ramp(np.clip(tone, 0, 1), stops)), normals(fibre, 1.5), surface(LEAST_ROUGHNESS + 0.2 * fibre))


def plaster(size: int, seed: int, stops: Sequence[Color]) -> Maps:
    """Draw scratched plaster with stains that run down."""
    grain, cloud = fractal(size, seed, 0.3), fractal(size, seed + 1, 1.2)
    run = fractal(size, seed + 2, 0.9, (0.25, 3.0))
    color = ramp(np.clip(0.3 * grain + 0.4 * cloud + 0.3 * run, 0, 1), stops)
    return picture(color), normals(grain, 1.2), surface(0.85 + 0.1 * grain)


def paint(size: int, seed: int, color: Color) -> Maps:
    """Draw powder coating: orange peel, chalky fading, dust in streaks."""
    grain, cloud, run = (
        fractal(size, seed, 0.5),
        fractal(size, seed + 1, 1.1),
        fractal(size, seed + 2, 0.8, (0.2, 4.0)),
    )
    tone = 0.8 + 0.12 * cloud + 0.1 * grain + 0.08 * run
    return (picture(np.array(color) * tone[..., None]), normals(grain, 0.4), surface(LEAST_ROUGHNESS + 0.15 * cloud))


def hedge(size: int, seed: int) -> Maps:
    """Draw a clipped box hedge."""
    field, cloud = resized(photo("grass"), size), fractal(size, seed, 1.0)
    tone = np.clip(0.8 * field + 0.4 * (cloud - 0.4), 0, 1)
    return (
        picture(ramp(tone, [(0.06, 0.11, 0.05), (0.2, 0.31, 0.12), (0.42, 0.52, 0.26)])),
        normals(field, 6.0),
        surface(0.85 + 0.1 * field),
    )
