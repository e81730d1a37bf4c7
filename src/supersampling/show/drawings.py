"""Drawings: the legend of the motion wheel, the jitter positions, and text."""

from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from supersampling.show import paint
from supersampling.show.clip import Array
from supersampling.show.paint import Picture

GROUND = (30, 32, 36)
INK = (235, 235, 235)
FAINT = (165, 168, 175)
_LINE = (95, 98, 106)
_NOW = (255, 176, 32)
_FINE = 4  # factor by which drawings are enlarged before they are reduced, for smooth edges


@cache
def font(size: int, bold: bool = False) -> ImageFont.FreeTypeFont:
    face = "DejaVuSans-Bold" if bold else "DejaVuSans"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"{face}.ttf"), size)


def wheel(size: tuple[int, int], full: float) -> Picture:
    """Draw the colours of motion: a disc of radius ``full`` pixels whose points have the colour of the vector from the
    centre."""
    width, height = size
    radius = max(1.0, min(width / 2 - 38.0, height / 2 - 18.0))  # room for the labels
    y, x = np.mgrid[0:height, 0:width] + 0.5
    vectors = np.stack((x - width / 2.0, y - height / 2.0)).astype(np.float32) * (full / radius)
    disc = np.hypot(*vectors) <= full
    picture = paint.motion(vectors, full)
    picture[~disc] = GROUND
    image = Image.fromarray(picture)
    draw, text = ImageDraw.Draw(image), font(11)
    for position, label, anchor in (
        ((width / 2, 9), "up", "mm"),
        ((width / 2, height - 9), "down", "mm"),
        ((width / 2 - radius - 4, height / 2), "left", "rm"),
        ((width / 2 + radius + 4, height / 2), "right", "lm"),
    ):
        draw.text(position, label, fill=FAINT, font=text, anchor=anchor)
    return np.asarray(image)


def jitter(size: tuple[int, int], positions: Array, scale: int) -> Picture:
    """Draw a low-resolution pixel with its ``scale x scale`` target pixels and the sample positions ``(T, 2)``.

    The last position is orange, earlier ones are grey.
    """
    width, height = (_FINE * side for side in size)
    image = Image.new("RGB", (width, height), GROUND)
    draw = ImageDraw.Draw(image)
    side = min(width, height) - 16 * _FINE
    left, top = (width - side) / 2, (height - side) / 2
    for k in range(scale + 1):
        offset = side * k / scale
        thick = 2 * _FINE if k in (0, scale) else _FINE
        draw.line((left + offset, top, left + offset, top + side), fill=_LINE, width=thick)
        draw.line((left, top + offset, left + side, top + offset), fill=_LINE, width=thick)
    radius = side / max(40, 6 * scale)
    for k, (x, y) in enumerate(positions):
        last = k == len(positions) - 1
        cx, cy, r = left + (x + 0.5) * side, top + (y + 0.5) * side, radius * (1.4 if last else 1.0)
        draw.ellipse((cx - r, cy - r, cx + r, cy + r), fill=_NOW if last else FAINT)
    return np.asarray(image.resize(size, Image.Resampling.LANCZOS))
