"""Checks of values that are invalid in every capture, at the time of reading."""

from pathlib import Path

import numpy as np

from supersampling.data.readers.images import Image
from supersampling.errors import UserError

MAX_JITTER = 0.5 + 1e-4  # pixels; an offset beyond its pixel is in a different unit


def checked_motion(motion: Image, path: Path) -> Image:
    """Return ``motion (h, w, 2)`` unchanged.

    Raises:
        UserError: most moving pixels would leave the image at once, as is the case for motion in pixels.
    """
    length = np.abs(motion).max(axis=-1)
    moving = int((length > 1e-4).sum())
    if int((length > 1.0).sum()) * 2 > moving:
        raise UserError(
            f"{path} has motion of up to {float(length.max()):.4g} image sizes, which seems to be in pixels: divide it "
            "by the "
            "image's width and height."
        )
    return motion


def checked_jitter(jitter: Image, path: Path) -> Image:
    """Return ``jitter (2,)`` unchanged.

    Raises:
        UserError: it leaves the pixel.
    """
    if float(np.abs(jitter).max()) > MAX_JITTER:
        raise UserError(
            f"{path} has a jitter of ({jitter[0]:.4g}, {jitter[1]:.4g}) low-resolution pixels, which leaves the pixel: "
            "write an "
            "offset from the centre of at most half a pixel."
        )
    return jitter
