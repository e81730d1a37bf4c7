"""Round dials with ticks and numbers: a gauge and a clock face."""

import numpy as np
from PIL import Image, ImageDraw

from supersampling.scenes.kit.lettering import aged, font
from supersampling.scenes.scene import Texture


def gauge(seed: int, unit: str, size: int = 256) -> Texture:
    """Draw a dial: fine ticks over 270 degrees, numbers, a red sector."""
    image = Image.new("RGB", (4 * size, 4 * size), (236, 232, 218))
    draw, s, c = ImageDraw.Draw(image), 4 * size, 2 * size
    draw.ellipse((4, 4, s - 4, s - 4), outline=(30, 30, 30), width=s // 30)
    draw.arc((s * 0.1, s * 0.1, s * 0.9, s * 0.9), 340, 45, (200, 40, 30), s // 18)
    for i in range(101):
        angle = np.radians(135 + 2.7 * i)
        inner = 0.34 if i % 10 == 0 else 0.37 if i % 5 == 0 else 0.385
        x, y = np.cos(angle), np.sin(angle)
        draw.line(
            (c + s * inner * x, c + s * inner * y, c + s * 0.42 * x, c + s * 0.42 * y),
            (20, 20, 20),
            s // (140 if i % 10 else 80),
        )
        if i % 10 == 0:
            draw.text(
                (c + s * 0.28 * x, c + s * 0.28 * y),
                str(i),
                (20, 20, 20),
                font(s // 16, "DejaVuSans-Bold"),
                anchor="mm",
            )
    draw.text((c, s * 0.68), unit, (20, 20, 20), font(s // 13, "DejaVuSans-Bold"), anchor="mm")
    draw.text((c, s * 0.8), f"No {4100 + seed}", (60, 60, 60), font(s // 24, "DejaVuSans"), anchor="mm")
    return aged(image.resize((size, size), Image.Resampling.BOX), seed, 0.12)


def clock_face(size: int = 512) -> Texture:
    """Draw a clock dial with sixty ticks and twelve numbers."""
    image = Image.new("RGB", (size, size), (238, 230, 208))
    draw, c = ImageDraw.Draw(image), size / 2
    for minute in range(60):
        angle = 2 * np.pi * minute / 60
        x, y = np.sin(angle), -np.cos(angle)
        inner = 0.42 if minute % 5 == 0 else 0.445
        ends = (c + size * inner * x, c + size * inner * y, c + size * 0.47 * x, c + size * 0.47 * y)
        draw.line(ends, (20, 20, 24), 9 if minute % 5 == 0 else 3)
        if minute % 5 == 0:
            place = (c + size * 0.355 * x, c + size * 0.355 * y)
            draw.text(place, str(minute // 5 or 12), (20, 20, 24), font(48, "DejaVuSerif-Bold"), anchor="mm")
    draw.text((c, size * 0.66), "RASTER & SONS", (70, 50, 30), font(22), anchor="mm")
    return np.asarray(image)
