"""Procedural textures: periodic noise, masonry, wood, metal, lattices and leaves, all seeded and repeating.

Fields are ``(S, S)`` float in [0, 1]; pictures are ``(S, S, C)`` uint8 sRGB. Row 0 is the top.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skimage import data, transform

from supersampling.scenes.scene import Texture

Field = NDArray[np.float64]
Maps = tuple[Texture, Texture, Texture]  # albedo, normal, surface


def fractal(size: int, seed: int, slope: float = 1.0, stretch: tuple[float, float] = (1.0, 1.0)) -> Field:
    """Return periodic noise of spectrum ``1 / f^slope``, its middle 98% spread over [0, 1].

    ``stretch`` (down, right) > 1 draws it out.
    """
    y = np.fft.fftfreq(size)[:, None] * size * stretch[0]
    x = np.fft.rfftfreq(size)[None] * size * stretch[1]
    frequency = np.hypot(y, x)
    frequency[0, 0] = np.inf
    white = np.fft.rfft2(np.random.default_rng(seed).standard_normal((size, size)))
    field = np.fft.irfft2(white / frequency**slope, (size, size))
    low, high = np.quantile(field[::4, ::4], [0.01, 0.99])
    return np.clip((field - low) / (high - low), 0, 1)


def picture(color: ArrayLike) -> Texture:
    """Convert float RGB(A) in [0, 1] to uint8, rounded."""
    return (np.clip(np.asarray(color), 0, 1) * 255 + 0.5).astype(np.uint8)


def ramp(field: Field, stops: Sequence[Sequence[float]]) -> Field:
    """Return colours ``(..., 3)`` by linear interpolation of evenly spaced sRGB ``stops``."""
    places = np.linspace(0, 1, len(stops))
    return np.stack([np.interp(field, places, [s[i] for s in stops]) for i in range(3)], -1)


def normals(height: Field, strength: float) -> Texture:
    """Return the tangent-space normal map of a periodic height field; green points up the image.

    ``strength`` is the height in texels.
    """
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2 * strength
    dy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2 * strength
    normal = np.stack([-dx, dy, np.ones_like(dx)], -1)
    return picture(normal / np.linalg.norm(normal, axis=-1, keepdims=True) * 0.5 + 0.5)


def surface(roughness: ArrayLike, metallic: ArrayLike = 0.0, emission: ArrayLike = 1.0) -> Texture:
    """Return the surface map (R roughness, G metallic, B emission mask) of fields or constants."""
    return picture(np.stack(np.broadcast_arrays(*(np.asarray(v, float) for v in (roughness, metallic, emission))), -1))


@cache
def photo(name: str) -> Field:
    """Return scikit-image's ``gravel`` or ``grass`` (CC0), 512 x 512, blended with a shifted copy: it repeats."""
    image = getattr(data, name)().astype(float) / 255
    ramp_up = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(512) + 0.5) / 512)
    weight = np.minimum(ramp_up[:, None], ramp_up[None])
    weight = np.clip((weight - 0.02) * 4, 0, 1)
    shifted = np.roll(image, (256, 256), (0, 1))
    mean = image.mean()
    mixed = (weight * (image - mean) + (1 - weight) * (shifted - mean)) / np.hypot(weight, 1 - weight)
    return np.clip(mixed + mean, 0, 1)


def resized(field: Field, size: int) -> Field:
    return np.asarray(transform.resize(field, (size, size), order=1, mode="wrap", anti_aliasing=False))


def masonry(
    size: int, rows: int, columns: int, gap: float, seed: int, shift: float = 0.5
) -> tuple[Field, Field, Field]:
    """Return running bond: 1 inside a stone and 0 in the joint; a random value per stone; height with rounded edges."""
    y, x = np.mgrid[:size, :size] / size
    row = np.floor(y * rows).astype(int)
    along = x * columns + shift * (row % 2)
    column = np.floor(along).astype(int) % columns
    value = np.random.default_rng(seed).random((rows, columns))[row % rows, column]
    wobble = (fractal(size, seed + 1, 1.2) - 0.5) * gap * 0.7
    edge_y = np.minimum((y * rows) % 1, 1 - (y * rows) % 1) / rows
    edge_x = np.minimum(along % 1, 1 - along % 1) / columns
    distance = np.minimum(edge_x, edge_y) + wobble
    inside = np.clip((distance - gap / 2) * size / 1.5, 0, 1)
    return inside, value, np.clip((distance - gap / 2) / (gap * 1.2), 0, 1) ** 0.5


def bricks(size: int, rows: int, columns: int, stops: Sequence[Sequence[float]], seed: int) -> Maps:
    """Draw a brick wall: albedo, normal, surface."""
    inside, value, height = masonry(size, rows, columns, 0.012, seed)
    grain, stain, pits = (fractal(size, seed + 2, 0.35), fractal(size, seed + 3, 1.1), fractal(size, seed + 4, 0.8))
    body = ramp(np.clip(value * 0.8 + 0.35 * (stain - 0.5) + 0.1, 0, 1), stops) * (0.62 + 0.75 * grain[..., None])
    body *= np.where(pits > 0.84, 0.62, 1.0)[..., None]
    mortar = np.array([0.72, 0.69, 0.63]) * (0.65 + 0.6 * grain[..., None])
    albedo = picture(inside[..., None] * body + (1 - inside[..., None]) * mortar)
    relief = height * 0.8 + 0.14 * grain - 0.12 * (pits > 0.84)
    return albedo, normals(relief, 7.0), surface(0.72 + 0.25 * grain)


def floor_tiles(size: int, count: int, colors: Sequence[Sequence[Sequence[float]]], seed: int) -> Maps:
    """Draw checkered marble with veins, inlaid diamonds and joints: albedo, normal, surface."""
    inside, value, height = masonry(size, count, count, 0.006, seed, 0.0)
    y, x = np.mgrid[:size, :size] / size * count
    checker = (np.floor(x) + np.floor(y)) % 2
    diamond = np.abs(x % 1 - 0.5) + np.abs(y % 1 - 0.5)
    checker = np.where((diamond < 0.26) | ((diamond > 0.3) & (diamond < 0.33)), 1 - checker, checker)
    turbulence = fractal(size, seed + 5, 1.15)
    veins = 1 - np.clip(np.abs(((turbulence * 7 + value * 3) % 1) - 0.5) * 9, 0, 1)
    grain = fractal(size, seed + 6, 0.3)
    tone = np.clip(0.45 + 0.35 * (value - 0.5) + 0.5 * (turbulence - 0.5) + 0.4 * (grain - 0.5), 0, 1)
    body = np.where(checker[..., None] > 0.5, ramp(tone, colors[0]), ramp(tone, colors[1]))
    body = body * (1 - 0.4 * veins[..., None]) + 0.35 * veins[..., None] * np.array([0.9, 0.85, 0.75])
    albedo = inside[..., None] * body + (1 - inside[..., None]) * 0.25
    return (picture(albedo), normals(height + 0.1 * grain, 4.0), surface(0.25 + 0.4 * grain + 0.3 * (1 - inside)))


def cobbles(size: int, seed: int) -> Maps:
    """Draw rounded setts in running bond with grit between: albedo, normal, surface."""
    inside, value, height = masonry(size, 12, 12, 0.014, seed)
    grit = resized(photo("gravel"), size)
    tone = np.clip(value * 0.7 + 0.6 * (grit - 0.4), 0, 1)
    stone = ramp(tone, [(0.24, 0.25, 0.29), (0.55, 0.52, 0.48), (0.74, 0.67, 0.57)])
    dirt = ramp(grit, [(0.16, 0.13, 0.09), (0.62, 0.55, 0.42)])
    return (
        picture(inside[..., None] * stone + (1 - inside[..., None]) * dirt),
        normals(height + 0.25 * grit, 8.0),
        surface(0.5 + 0.4 * grit),
    )


def stone(size: int, seed: int, stops: Sequence[Sequence[float]], rows: int = 4) -> Maps:
    """Draw ashlar blocks with pits and chisel marks: albedo, normal, surface."""
    inside, value, height = masonry(size, rows, max(rows // 2, 1), 0.006, seed)
    grain, cloud = fractal(size, seed + 1, 0.35), fractal(size, seed + 2, 1.2)
    chisel = fractal(size, seed + 3, 0.5, (1.0, 6.0))
    pits = fractal(size, seed + 4, 0.7) > 0.86
    body = ramp(np.clip(0.25 * value + 0.55 * cloud + 0.35 * grain, 0, 1), stops) * (0.8 + 0.35 * chisel[..., None])
    body = np.where(pits[..., None], body * 0.55, body)
    albedo = picture(body * (0.45 + 0.55 * inside[..., None]))
    return (albedo, normals(height * 0.7 + 0.2 * grain + 0.2 * chisel - 0.2 * pits, 6.0), surface(0.7 + 0.25 * grain))


def wood(size: int, seed: int, stops: Sequence[Sequence[float]], planks: int = 6) -> Maps:
    """Draw planks along v with grain: albedo, normal, surface."""
    x = np.mgrid[:size, :size][1] / size * planks
    value = np.random.default_rng(seed).random(planks)[np.floor(x).astype(int) % planks]
    warp = fractal(size, seed + 1, 1.4, (0.35, 3.0))
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (x * 4 + 9 * warp + 5 * value))
    fibre = fractal(size, seed + 2, 0.4, (8.0, 1.0))
    gap = np.minimum(x % 1, 1 - x % 1) < 0.018
    tone = np.clip(0.35 * value + 0.35 * rings + 0.4 * fibre, 0, 1)
    albedo = np.where(gap[..., None], 0.08, ramp(tone, stops))
    return picture(albedo), normals(0.5 * fibre + 0.3 * rings - 0.8 * gap, 4.0), surface(0.45 + 0.35 * fibre)


def rough(size: int, seed: int, stops: Sequence[Sequence[float]], base: str = "gravel") -> Maps:
    """Draw ground from one of scikit-image's photographs: albedo, normal, surface."""
    field, cloud = resized(photo(base), size), fractal(size, seed, 1.2)
    tone = np.clip(field * 0.8 + 0.35 * (cloud - 0.5) + 0.1, 0, 1)
    return picture(ramp(tone, stops)), normals(field, 5.0), surface(0.75 + 0.2 * field)


def lattice(size: int, cells: int, bar: float, color: Sequence[float], seed: int, slant: bool = False) -> Texture:
    """Draw woven bars with holes, RGBA; alpha is 0 in the holes.

    ``slant`` turns the weave by 45 degrees; ``bar`` is the width of a bar as a share of a cell.
    """
    y, x = np.mgrid[:size, :size] / size * cells
    if slant:
        x, y = x + y, x - y
    across, along = np.abs(x % 1 - 0.5), np.abs(y % 1 - 0.5)
    solid = np.maximum(bar / 2 - across, bar / 2 - along) * size / cells
    light = 1 - 1.2 * np.minimum(across, along) / bar
    tone = light * (0.6 + 0.7 * fractal(size, seed, 0.6))
    return picture(np.concatenate([np.array(color) * tone[..., None], np.clip(solid + 0.5, 0, 1)[..., None]], -1))


def foliage(size: int, seed: int, count: int, stops: Sequence[Sequence[float]]) -> Texture:
    """Draw scattered leaves with a midrib, RGBA, alpha 0 outside of them; repeats."""
    rng = np.random.default_rng(seed)
    image = np.zeros((size, size, 4))
    image[..., :3] = stops[0]
    reach = size // 10
    v, u = np.mgrid[-reach : reach + 1, -reach : reach + 1] / reach
    for _ in range(count):
        angle, tone = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 1)
        a, b = np.cos(angle) * u + np.sin(angle) * v, np.cos(angle) * v - np.sin(angle) * u
        leaf = np.abs(b) < 0.42 * (1 - a**2) * (1 - 0.4 * a)
        shade = (0.75 + 0.25 * np.cos(a * 26 - np.abs(b) * 18)) * np.where(np.abs(b) < 0.05, 1.35, 1.0)
        rows = (np.arange(2 * reach + 1) + rng.integers(size)) % size
        columns = (np.arange(2 * reach + 1) + rng.integers(size)) % size
        patch = image[np.ix_(rows, columns)]
        patch[leaf] = np.concatenate(
            [ramp(np.full(1, tone), stops) * shade[leaf][:, None], np.ones((leaf.sum(), 1))], 1
        )
        image[np.ix_(rows, columns)] = patch
    return picture(image)
