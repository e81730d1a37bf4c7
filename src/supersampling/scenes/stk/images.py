"""Textures of the game: resized to powers of two up to a limit, with transparent texels filled by the mean colour."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from supersampling.scenes.scene import Texture

LARGEST = 1024


def linear(srgb: NDArray[np.floating]) -> NDArray[np.float32]:
    """Convert sRGB values in [0, 1] to linear light (IEC 61966-2-1)."""
    curve = ((np.maximum(srgb, 0.0) + 0.055) / 1.055) ** 2.4
    return np.where(srgb <= 0.04045, srgb / 12.92, curve).astype(np.float32)


def read_image(path: Path, alpha: bool, largest: int = LARGEST) -> Texture:
    """Read ``(H, W, 3)``, or ``(H, W, 4)`` with ``alpha``; each side is the nearest power of two up to ``largest``."""
    with Image.open(path) as image:
        # JPEG decodes to a half or a quarter at a quarter of the cost.
        image.draft("RGB", (largest, largest))
        whole = image.convert("RGBA")
    size = (_power_of_two(whole.width, largest), _power_of_two(whole.height, largest))
    # Resize bands one by one: resizing RGBA at once would turn the colour of transparent texels black.
    bands = [
        band if band.size == size else band.resize(size, Image.Resampling.BOX)
        for band in whole.split()[: 4 if alpha else 3]
    ]
    texture = np.stack([np.asarray(band) for band in bands], axis=-1)
    return _filled(texture) if alpha else texture


def masked(color: Texture, mask: Texture) -> Texture:
    """Return ``color``'s RGB with ``mask``'s first band, resized to match, as alpha."""
    band = Image.fromarray(np.ascontiguousarray(mask[..., 0])).resize((color.shape[1], color.shape[0]))
    return np.concatenate([color[..., :3], np.asarray(band)[..., None]], axis=-1)


def upright_normals(texture: Texture) -> Texture:
    """Return a normal map with green up (OpenGL's convention); the game has maps of both conventions.

    The slopes of a surface have no curl, so the right sign of the green channel is the one with less curl.
    """
    x, y, z = np.moveaxis(texture[..., :3].astype(np.float32) / 127.5 - 1.0, -1, 0)
    along, up = -x / np.maximum(z, 0.2), -y / np.maximum(z, 0.2)
    # Rows run down, so a step up is a step back along axis 0.
    turn = -_difference(along, 0)
    if np.abs(turn - _difference(up, 1)).mean() <= np.abs(turn + _difference(up, 1)).mean():
        return texture
    out = texture.copy()
    out[..., 1] = 255 - out[..., 1]
    return out


def _difference(values: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    return np.roll(values, -1, axis) - np.roll(values, 1, axis)


def _power_of_two(side: int, largest: int) -> int:
    return min(largest, 1 << max(0, round(np.log2(max(side, 1)))))


def _filled(texture: Texture) -> Texture:
    """Give transparent texels the mean colour of the others: filtering blends it into the edges of leaves."""
    weight = texture[..., 3:].astype(np.float32)
    if not 0.0 < weight.sum() < 255.0 * weight.size:
        return texture
    mean = (texture[..., :3] * weight).sum(axis=(0, 1)) / weight.sum()
    out = texture.copy()
    out[..., :3] = np.where(weight < 16.0, mean, texture[..., :3])
    return out
