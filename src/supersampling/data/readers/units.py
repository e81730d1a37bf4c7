"""Checks of single values as they are read: what cannot be right in any capture."""

from pathlib import Path

import numpy as np

from supersampling.data.readers.images import Image
from supersampling.errors import UserError

MAX_JITTER = 0.5 + 1e-4  # pixels; an offset beyond its own pixel is in another unit


def checked_motion(motion: Image, path: Path) -> Image:
    """Motion ``(h, w, 2)`` itself.

    Raises:
        UserError: most of what moves would leave the image at once, as pixels taken for fractions of the image do.
    """
    length = np.abs(motion).max(axis=-1)
    moving = int((length > 1e-4).sum())
    if int((length > 1.0).sum()) * 2 > moving:
        raise UserError(
            f"{path} holds motion of up to {float(length.max()):.4g} image sizes, so it seems to be in pixels: divide it by the "
            "image's width and height."
        )
    return motion


def checked_jitter(jitter: Image, path: Path) -> Image:
    """Jitter ``(2,)`` itself.

    Raises:
        UserError: it leaves the pixel.
    """
    if float(np.abs(jitter).max()) > MAX_JITTER:
        raise UserError(
            f"{path} has a jitter of ({jitter[0]:.4g}, {jitter[1]:.4g}) low-resolution pixels, which leaves the pixel: it "
            "must be an offset from the centre within half a pixel."
        )
    return jitter
