"""Textures of the user interface: name plates, the head-up display's panels, signs. RGB, or RGBA with hard holes."""

import numpy as np
from PIL import Image, ImageDraw

from supersampling.scenes.kit.lettering import Rgb, font
from supersampling.scenes.scene import Texture

INK: Rgb = (236, 238, 240)
DIM: Rgb = (120, 132, 148)
BACK: Rgb = (22, 26, 34)
GOOD: Rgb = (88, 200, 96)
POWER: Rgb = (84, 160, 232)
BAD: Rgb = (226, 74, 58)
GOLD: Rgb = (240, 192, 72)
_LOG = (
    "KESTREL parries MARROW-9",
    "+120 score   chain x3",
    "OLD TOLLER enters the ring",
    "FINCH repairs 64 armour",
    "MARROW-9 overheats (4.2 s)",
    "south gate opens in 00:31",
    "BRASS AUNT taunts the crowd",
    "supply drop at D4",
    "latency 23 ms   loss 0.0 %",
)


def _bar(draw: ImageDraw.ImageDraw, box: tuple[int, int, int, int], share: float, color: Rgb, ticks: int) -> None:
    """Draw a framed bar (left, top, right, bottom) filled to ``share``, with ``ticks`` divisions."""
    left, top, right, bottom = box
    draw.rectangle(box, (46, 50, 58), INK, 2)
    draw.rectangle((left + 4, top + 4, left + 4 + int((right - left - 8) * share), bottom - 4), color)
    for k in range(1, ticks):
        x = left + (right - left) * k // ticks
        draw.line((x, top + 3, x, bottom - 3), BACK, 2)


def plate(name: str, rank: str, level: int, health: tuple[int, int], color: Rgb) -> Texture:
    """Draw a name plate 512 x 160: name, rank, level, health bar with its figures."""
    image = Image.new("RGB", (512, 160), BACK)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, 511, 159), outline=color, width=5)
    draw.rectangle((5, 5, 92, 154), color)
    draw.text((49, 60), str(level), BACK, font(58, "DejaVuSans-Bold"), anchor="mm")
    draw.text((49, 118), "LEVEL", BACK, font(20, "DejaVuSans-Bold"), anchor="mm")
    draw.text((106, 12), name, INK, font(46, "DejaVuSans-Bold"))
    draw.text((106, 68), rank, DIM, font(26, "DejaVuSans"))
    share = health[0] / health[1]
    _bar(draw, (104, 104, 500, 148), share, GOOD if share > 0.5 else GOLD if share > 0.25 else BAD, 10)
    draw.text((302, 126), f"{health[0]} / {health[1]}", INK, font(28, "DejaVuSans-Bold"), anchor="mm")
    return np.asarray(image)


def mark(text: str, color: Rgb) -> Texture:
    """Draw a sign 128 x 128 above a head, RGBA: a letter in a lozenge."""
    image = Image.new("RGBA", (128, 128), (*color, 0))
    draw = ImageDraw.Draw(image)
    draw.polygon([(64, 2), (125, 64), (64, 125), (2, 64)], (*color, 255), (*INK, 255), 6)
    draw.text((64, 62), text, (*BACK, 255), font(72, "DejaVuSans-Bold"), anchor="mm")
    return np.asarray(image)


def vitals() -> Texture:
    """Draw a panel 768 x 256 of the player: portrait, name, three bars, small figures."""
    image = Image.new("RGB", (768, 256), BACK)
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 0, 767, 255), outline=POWER, width=5)
    draw.rectangle((16, 16, 239, 239), (52, 62, 78), POWER, 4)
    draw.ellipse((70, 40, 186, 170), (150, 162, 176), INK, 4)
    draw.rectangle((84, 92, 172, 112), GOLD)
    draw.polygon([(40, 236), (80, 176), (176, 176), (216, 236)], (120, 64, 52), INK)
    draw.text((258, 14), "WREN, ring marshal", INK, font(42, "DejaVuSans-Bold"))
    for k, (label, share, color, figure) in enumerate(
        (("ARMOUR", 0.72, GOOD, "1440/2000"), ("POWER", 0.45, POWER, "90/200"), ("HEAT", 0.18, BAD, "18 %"))
    ):
        y = 78 + 54 * k
        draw.text((258, y + 6), label, DIM, font(28, "DejaVuSans-Bold"))
        _bar(draw, (400, y, 750, y + 42), share, color, 8 + 4 * k)
        draw.text((575, y + 20), figure, INK, font(26, "DejaVuSans-Bold"), anchor="mm")
    return np.asarray(image)


def title() -> Texture:
    """Draw a panel 1024 x 128 of the round: two scores, the clock, small type."""
    image = Image.new("RGB", (1024, 128), BACK)
    draw = ImageDraw.Draw(image)
    for left, color, name, score, share in ((0, BAD, "RED FORGE", 14, 0.63), (664, POWER, "BLUE YARD", 11, 0.48)):
        draw.rectangle((left, 0, left + 359, 127), (34, 38, 48), color, 4)
        draw.text((left + 16, 10), name, INK, font(40, "DejaVuSans-Bold"))
        draw.text((left + 344, 6), str(score), color, font(48, "DejaVuSans-Bold"), anchor="ra")
        _bar(draw, (left + 16, 70, left + 344, 108), share, color, 12)
    draw.text((512, 44), "02:47", INK, font(68, "DejaVuSansMono-Bold"), anchor="mm")
    draw.text((512, 102), "ROUND 3 OF 5", GOLD, font(30, "DejaVuSans-Bold"), anchor="mm")
    return np.asarray(image)


def log() -> Texture:
    """Draw lines of small type 768 x 384 without a ground, RGBA, a dark rim around every letter."""
    image = Image.new("RGBA", (768, 384), (*BACK, 0))
    draw = ImageDraw.Draw(image)
    for k, line in enumerate(_LOG):
        color = GOLD if line.startswith("+") else INK if k % 2 else (190, 214, 240)
        look = font(30, "DejaVuSans-Bold" if k % 3 == 0 else "DejaVuSans")
        draw.text((8, 6 + 42 * k), line, (*color, 255), look, stroke_width=2, stroke_fill=(*BACK, 255))
    return np.asarray(image)


def map_face() -> Texture:
    """Draw a round map 320 x 320 of the ring, RGBA: rings, spokes, letters, dots."""
    image = Image.new("RGBA", (320, 320), (*BACK, 0))
    draw = ImageDraw.Draw(image)
    draw.ellipse((2, 2, 317, 317), (*BACK, 255), (*INK, 255), 5)
    for radius in (40, 80, 120):
        draw.ellipse((160 - radius, 160 - radius, 160 + radius, 160 + radius), outline=(*DIM, 255), width=2)
    for k in range(12):
        a = np.pi / 6 * k
        c, s = np.cos(a), np.sin(a)
        draw.line((160 + 120 * c, 160 + 120 * s, 160 + 154 * c, 160 + 154 * s), (*DIM, 255), 3)
    for k, letter in enumerate("ESWN"):
        a = np.pi / 2 * k
        place = (160 + 134 * np.cos(a), 160 + 134 * np.sin(a))
        draw.text(place, letter, (*GOLD, 255), font(30, "DejaVuSans-Bold"), anchor="mm")
    for x, y, color in ((104, 130, BAD), (212, 110, BAD), (190, 220, POWER), (120, 214, POWER), (230, 180, GOLD)):
        draw.rectangle((x - 7, y - 7, x + 7, y + 7), (*color, 255), (*INK, 255))
    return np.asarray(image)


def aim() -> Texture:
    """Draw a cross-hair 256 x 256, RGBA."""
    image = Image.new("RGBA", (256, 256), (*INK, 0))
    draw = ImageDraw.Draw(image)
    draw.ellipse((60, 60, 196, 196), outline=(*INK, 255), width=5)
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        draw.line((128 + 44 * x, 128 + 44 * y, 128 + 120 * x, 128 + 120 * y), (*GOLD, 255), 5)
    draw.rectangle((125, 125, 131, 131), (*BAD, 255))
    return np.asarray(image)


def slots() -> Texture:
    """Draw a row of five tools 800 x 160 with their keys and counts."""
    image = Image.new("RGB", (800, 160), BACK)
    draw = ImageDraw.Draw(image)
    for k, (word, count) in enumerate((("LANCE", 1), ("NET", 4), ("FLARE", 12), ("PATCH", 3), ("HORN", 1))):
        left = 160 * k
        draw.rectangle((left + 4, 4, left + 155, 155), (40, 46, 58), GOLD if k == 1 else DIM, 5)
        draw.text((left + 14, 10), str(k + 1), DIM, font(30, "DejaVuSans-Bold"))
        draw.text((left + 146, 10), f"x{count}", INK, font(28, "DejaVuSans-Bold"), anchor="ra")
        draw.text((left + 80, 82), word[0], GOLD, font(60, "DejaVuSerif-Bold"), anchor="mm")
        draw.text((left + 80, 134), word, INK, font(26, "DejaVuSans-Bold"), anchor="mm")
    return np.asarray(image)
