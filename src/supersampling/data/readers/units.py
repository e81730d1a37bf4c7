"""Checks of values that are invalid in every capture, at the time of reading."""

from pathlib import Path

import numpy as np

from supersampling.data.readers.images import Image
from supersampling.errors import UserError

MAX_JITTER = 0.5 + 1e-4  # pixels; an offset beyond its pixel is in a different unit
MARKED = 0.01  # share of pixels that move by the same whole number of images, which no surface does
NOTHING = (0.48, 0.52)  # what an unsigned encoding stores for no motion
DARK = 1e-3  # radiance below zero that a filter with negative lobes may leave, relative to the largest
LENGTH = 0.05  # tolerance of a unit vector's length


def checked_motion(motion: Image, path: Path) -> Image:
    """Return ``motion (h, w, 2)`` unchanged.

    Raises:
        UserError: most moving pixels would leave the image at once, as is the case for motion in pixels; or values are
        an encoding around 0.5, or a mark of pixels without motion.
    """
    length = np.abs(motion).max(axis=-1)
    moving = int((length > 1e-4).sum())
    middle = np.abs(np.median(motion, axis=(0, 1)))
    if NOTHING[0] < middle.min() and middle.max() < NOTHING[1]:
        raise UserError(
            f"{path} has motion of ({middle[0]:.3g}, {middle[1]:.3g}) in most pixels, which seems to be an unsigned "
            "encoding where 0.5 is no motion: write signed fractions of the image's width and height."
        )
    if int((length > 1.0).sum()) * 2 > moving:
        raise UserError(
            f"{path} has motion of up to {float(length.max()):.4g} image sizes, which seems to be in pixels: divide it "
            "by the image's width and height."
        )
    marked = motion[length >= 1.0]
    if len(marked) > MARKED * length.size and (marked == np.round(marked[0])).all():
        raise UserError(
            f"{path} has exactly ({marked[0, 0]:.4g}, {marked[0, 1]:.4g}) in {len(marked) / length.size:.1%} of the "
            "pixels, which seems to mark pixels without motion: write the camera's motion there, and 0 where nothing "
            "moves."
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


def checked_light(light: Image, path: Path) -> Image:
    """Return ``light (h, w, 3)`` without the small negative values that filters leave.

    Raises:
        UserError: values are clearly negative, which no light is.
    """
    lowest = float(light.min())
    if lowest < -DARK * max(float(light.max()), 1.0):
        raise UserError(
            f"{path} has {int((light < 0.0).sum())} negative values, down to {lowest:.4g}: export linear light, which "
            "is at least 0."
        )
    return np.maximum(light, 0.0)


def checked_normal(normal: Image, path: Path) -> Image:
    """Return ``normal (h, w, 3)`` unchanged.

    Raises:
        UserError: components leave [-1, 1], or are stored in [0, 1].
    """
    largest = float(np.abs(normal).max())
    if largest > 1.0 + LENGTH:
        raise UserError(f"{path} has normals with components of up to {largest:.4g}: write unit vectors.")
    shown = normal[(normal != 0.0).any(axis=-1)]
    if len(shown) and shown.min() >= 0.0:
        unit, encoded = (float(np.median(np.linalg.norm(v, axis=-1))) for v in (shown, 2.0 * shown - 1.0))
        if abs(encoded - 1.0) < LENGTH < abs(unit - 1.0):
            raise UserError(
                f"{path} has normals between {shown.min():.2g} and {shown.max():.2g}, which seem to be stored as "
                "(n + 1) / 2: write components between -1 and 1."
            )
    return normal
