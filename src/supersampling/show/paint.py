"""Buffers as pictures: float32 ``(C, h, w)`` in, 8-bit RGB ``(h, w, 3)`` out."""

import numpy as np
import torch
from kornia.color import linear_rgb_to_rgb
from matplotlib import colormaps
from matplotlib.colors import hsv_to_rgb
from numpy.typing import NDArray
from torchvision.utils import flow_to_image

from supersampling.ops.display import radiance_to_display
from supersampling.show.clip import Array

Picture = NDArray[np.uint8]

BROKEN = (255, 0, 255)
_SKY = (16, 16, 20)
_OUTSIDE = (70, 90, 120)
_MASK = (255, 40, 40)
# Steps of the golden ratio spread any number of hues evenly over the circle.
_GOLDEN = 0.6180339887498949


def _eight_bits(values: NDArray[np.floating]) -> Picture:
    """Return ``(h, w, 3)`` in [0, 1] in 8 bits."""
    return np.round(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)


def colour(values: Array) -> Picture:
    """Paint display-referred colour unchanged."""
    return _eight_bits(values.transpose(1, 2, 0))


def light(values: Array, stops: int) -> Picture:
    """Paint linear radiance, ``2 ** stops`` times as bright, with the project's tone map."""
    return colour(radiance_to_display(torch.from_numpy(values) * 2.0**stops).numpy())


def reflectance(values: Array) -> Picture:
    """Paint linear reflectance, clamped at 1, with the sRGB curve only."""
    return colour(linear_rgb_to_rgb(torch.from_numpy(values).clamp(0.0, 1.0)[None])[0].numpy())


def grey(values: Array) -> Picture:
    """Paint a scalar ``(1, h, w)`` in [0, 1]."""
    return colour(np.repeat(values, 3, axis=0))


def normal(values: Array) -> Picture:
    """Paint normals as ``0.5 + 0.5 n``."""
    return colour(0.5 + 0.5 * values)


def depth(values: Array, nearest: float, farthest: float) -> Picture:
    """Paint depth ``(1, h, w)`` from yellow at ``nearest`` to violet at ``farthest``, by its square root; sky (1) is
    black."""
    low, high = np.sqrt(max(nearest, 0.0)), np.sqrt(max(farthest, 0.0))
    position = (np.sqrt(np.maximum(values[0], 0.0)) - low) / max(high - low, 1e-6)
    picture = _eight_bits(colormaps["viridis_r"](np.clip(position, 0.0, 1.0))[..., :3])
    picture[values[0] >= 1.0] = _SKY
    return picture


def ids(values: Array) -> Picture:
    """Paint object numbers ``(1, h, w)``, each in a hue that is the same in every picture; 0 (sky) is black."""
    number = np.round(values[0].astype(np.float64))
    hue, saturation, value = (
        (number * _GOLDEN) % 1.0,
        0.5 + 0.4 * (number * 0.37 % 1.0),
        0.95 - 0.4 * (number * 0.73 % 1.0),
    )
    picture = _eight_bits(hsv_to_rgb(np.stack((hue, saturation, value), axis=-1)))
    picture[number == 0] = _SKY
    return picture


def motion(pixels: Array, full: float) -> Picture:
    """Paint vectors ``(2, h, w)`` by the colour wheel of Baker et al. 2007 (`torchvision.utils.flow_to_image`).

    Hue is direction, white is no motion, full colour is a length of at least ``full`` pixels.
    """
    length = np.hypot(pixels[0], pixels[1])
    limited = pixels * np.minimum(1.0, full / np.maximum(length, 1e-12))
    # The function scales by the longest vector in the image: an additional column holds it, with a margin for rounding.
    longest = np.zeros((2, limited.shape[1], 1), dtype=np.float32)
    longest[0] = full * (1.0 + 1e-5)
    image = flow_to_image(torch.from_numpy(np.concatenate((limited, longest), axis=2).astype(np.float32)))
    return np.ascontiguousarray(image[:, :, :-1].permute(1, 2, 0).numpy())


def difference(values: Array, full: float, inside: NDArray[np.bool_]) -> Picture:
    """Paint an error ``(h, w)`` from black at 0 to bright at ``full``; pixels that are not ``inside`` are slate
    blue."""
    picture = _eight_bits(colormaps["inferno"](np.clip(values / full, 0.0, 1.0))[..., :3])
    picture[~inside] = _OUTSIDE
    return picture


def masked(picture: Picture, mask: NDArray[np.bool_]) -> Picture:
    """Paint ``mask (h, w)`` in red over ``picture``, which is darkened and desaturated so that few pixels stand out."""
    grey_level = picture.mean(axis=2, keepdims=True)
    over = np.round(0.3 * (picture + grey_level)).astype(np.uint8)
    over[mask] = _MASK
    return over
