"""Textures of the airstrip: weathered paint, grass, crowns of trees, cast slabs."""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from supersampling.scenes.kit import textures
from supersampling.scenes.kit.lettering import Rgb
from supersampling.scenes.scene import Texture


@cache
def _weather(side: int) -> tuple[textures.Field, textures.Field]:
    """Return how faded and how chipped a square of paint is."""
    fade, fine = textures.fractal(side, 81, 1.1), textures.fractal(side, 82, 0.35)
    streak = textures.fractal(side, 83, 0.8, (0.2, 3.0))
    chips = np.clip((textures.fractal(side, 84, 0.7) - 0.9) * 12, 0, 1)
    return 0.5 * fade + 0.7 * fine + 0.5 * np.clip(streak * 3 - 1.8, 0, 1), chips


def worn(image: NDArray[np.uint8], seed: int, amount: float) -> Texture:
    """Fade, scratch and streak a coat of paint."""
    height, width = image.shape[:2]
    shift = tuple(np.random.default_rng(seed).integers(1024, size=2))
    fade, chips = (np.roll(f, shift, (0, 1))[:height, :width, None] for f in _weather(max(height, width)))
    color = image / 255 * (1 - amount * fade)
    return textures.picture(np.clip(color + chips * (np.array([0.5, 0.48, 0.44]) - color), 0.09, 0.93))


def blades(size: int, seed: int) -> Texture:
    """Draw a tuft of grass, RGBA, its root at the lower edge."""
    image = Image.new("RGBA", (size, size), (60, 84, 30, 0))
    draw, rng = ImageDraw.Draw(image), np.random.default_rng(seed)
    for _ in range(34):
        x, lean, tall = rng.normal(0.5, 0.15), rng.normal(0, 0.2), rng.uniform(0.3, 0.95)
        t = np.linspace(0, 1, 7)
        across, up = (x + lean * t**2) * size, size * (1 - tall * t)
        wide = size * 0.02 * (1 - t) + 0.6
        tone = rng.uniform(0.6, 1.15)
        color = tuple(int(tone * c) for c in ((124, 138, 62), (160, 150, 84), (92, 116, 52))[rng.integers(3)])
        line = [*zip(across - wide, up), *zip((across + wide)[::-1], up[::-1])]
        draw.polygon([(float(a), float(b)) for a, b in line], (*color, 255))
    return np.asarray(image)


def crown(size: int, seed: int) -> Texture:
    """Draw the crown of a tree, RGBA: leaves inside a ragged disc, darker towards its foot."""
    leaves = [(0.1, 0.16, 0.05), (0.26, 0.38, 0.12), (0.52, 0.58, 0.26)]
    image = textures.foliage(size, seed, 210, leaves).copy()
    y, x = np.mgrid[:size, :size] / size - 0.5
    lobes = 0.2 * (textures.fractal(size, seed + 1, 1.2) - 0.5) + 0.05 * (textures.fractal(size, seed + 2, 0.5) - 0.5)
    image[..., 3] = np.where(np.hypot(x, 1.08 * y) < 0.4 + lobes, image[..., 3], 0)
    shade = np.clip(0.8 - 0.9 * y - 0.5 * x + lobes, 0.35, 1.2)
    image[..., :3] = textures.picture(image[..., :3] / 255 * shade[..., None])
    return image


def striped(size: int, first: Rgb, second: Rgb, bands: int) -> Texture:
    """Draw bands along v."""
    row = np.mgrid[:size, :size][0] * bands // size % 2
    return worn(np.where(row[..., None] > 0, first, second).astype(np.uint8), bands, 0.3)


def patchy(maps: textures.Maps) -> textures.Maps:
    """Add dry patches and clover to a lawn."""
    albedo, normal, surface = maps
    size = len(albedo)
    dry, clover = textures.fractal(size, 91, 1.0), textures.fractal(size, 92, 0.6)
    tint = 1 + 0.5 * (dry[..., None] - 0.4) * [1.0, 0.5, 0.2] - 0.45 * (clover > 0.72)[..., None]
    return textures.picture(albedo / 255 * tint), normal, surface


def runway(size: int, seed: int) -> textures.Maps:
    """Draw cast slabs with tarred joints and cracks, patches, oil and tyre marks."""
    grain, cloud = textures.fractal(size, seed, 0.25), textures.fractal(size, seed + 1, 1.1)
    crack = np.abs(textures.fractal(size, seed + 2, 1.35) - 0.5) < 0.004
    y, x = np.mgrid[:size, :size]
    joint = (x % (size // 2) < 5) | (y % (size // 2) < 5)
    tone = np.random.default_rng(seed).uniform(-0.12, 0.12, (2, 2))[y * 2 // size, x * 2 // size]
    patch = (np.abs(x - 0.3 * size) < 0.09 * size) & (np.abs(y - 0.7 * size) < 0.06 * size)
    value = np.clip(0.45 + 0.5 * (grain - 0.5) + 0.4 * (cloud - 0.5) + tone - 0.25 * patch, 0, 1)
    color = textures.ramp(value, [(0.25, 0.25, 0.26), (0.45, 0.44, 0.42), (0.66, 0.64, 0.6)])
    marks = np.clip(textures.fractal(size, seed + 3, 0.9, (3.0, 0.2)) * 4 - 3.0, 0, 1)
    color *= (1 - 0.4 * marks - 0.55 * (joint | crack))[..., None]
    return (
        textures.picture(np.maximum(color, 0.16)),
        textures.normals(0.3 * grain - 0.6 * (joint | crack), 3.0),
        textures.surface(np.full((8, 8), 0.9)),
    )
