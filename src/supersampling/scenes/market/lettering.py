"""Lettering of the market: shop signs, price tags, slates, book covers, fruit crates and flour sacks."""

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from supersampling.scenes.kit.lettering import Rgb, font
from supersampling.scenes.kit.textures import Field, fractal, picture
from supersampling.scenes.scene import Texture

GOODS = (
    "Apples", "Pears", "Plums", "Quinces", "Cherries", "Apricots", "Figs", "Grapes", "Walnuts", "Chestnuts", "Honey",
    "Butter", "Goat Cheese", "Rye Bread", "Garlic", "Onions", "Leeks", "Carrots", "Beetroot", "Potatoes", "Pumpkin",
    "Thyme", "Sage", "Saffron", "Pepper", "Salt", "Lentils", "Barley", "Oats", "Cider", "Vinegar", "Olives",
)  # fmt: skip
_TITLES = (
    "The Harbour Map", "Twelve Winters", "A Field of Rye", "Tides", "The Glass Orchard", "On Bread", "North Road",
    "Lamps of the City", "The Ferryman", "Small Clocks", "A Year in Salt", "Hedgerows", "The Paper Moon", "Old Bells",
    "Market Days", "The Long Shadow",
)  # fmt: skip
_TALK = (
    "fresh this morning from the valley farms and sold by weight until noon or while the baskets last please bring "
    "your own bag and mind the step all prices in crowns and pence no credit before the harvest ask inside for orders "
    "deliveries and repairs open every day but sunday and the feast of the bridge"
)
_SPEECH = _TALK.split()


@cache
def _wear(side: int) -> tuple[Field, Field]:
    """Return grain and stains, shared by all drawings of a size."""
    return fractal(side, 100, 0.5), fractal(side, 101, 1.2)


def aged(image: Image.Image, seed: int, amount: float = 0.25) -> Texture:
    """Add the grain of paint or paper and a few stains to a drawing."""
    grain, stain = (np.roll(field, (67 * seed, 41 * seed), (0, 1)) for field in _wear(max(image.size)))
    worn = 1 - amount + 1.2 * amount * grain - 0.5 * amount * np.clip((stain - 0.6) * 2.5, 0, 1)
    return picture(np.asarray(image, float) / 255 * worn[: image.size[1], : image.size[0], None])


def speech(rng: np.random.Generator, words: int) -> str:
    start = int(rng.integers(len(_SPEECH)))
    return " ".join(_SPEECH[(start + k) % len(_SPEECH)] for k in range(words)).capitalize() + "."


def fitted(
    draw: ImageDraw.ImageDraw, place: tuple[float, float], text: str, ink: Rgb, box: tuple[float, int], face: str
) -> None:
    """Draw centred text of at most ``box`` (width, points)."""
    points = min(box[1], int(box[1] * box[0] / font(box[1], face).getlength(text)))
    draw.text(place, text, ink, font(max(points, 6), face), anchor="mm")


def fascia(seed: int, name: str, trade: str, back: Rgb, ink: Rgb, size: tuple[int, int] = (1024, 160)) -> Texture:
    """Draw the board above a shop: its name, its trade to both sides, a double rule."""
    width, height = size
    image = Image.new("RGB", size, back)
    draw = ImageDraw.Draw(image)
    for inset, line in ((8, 4), (17, 2)):
        draw.rectangle((inset, inset, width - 1 - inset, height - 1 - inset), outline=ink, width=line)
    shade = (back[0] // 2, back[1] // 2, back[2] // 2)
    for offset, color in ((4, shade), (0, ink)):
        fitted(draw, (width / 2 + offset, height * 0.43 + offset), name, color, (width * 0.62, 88), "DejaVuSerif-Bold")
    draw.text((width / 2, height * 0.81), trade, ink, font(19, "DejaVuSans"), anchor="mm")
    for x, text in ((width * 0.1, "EST."), (width * 0.9, "No.")):
        draw.text((x, height * 0.38), text, ink, font(22, "DejaVuSerif"), anchor="mm")
        draw.text((x, height * 0.62), str(1840 + 7 * seed if x < width / 2 else 3 + seed), ink, font(34), anchor="mm")
    return aged(image, 100 + seed, 0.3)


def hanging_sign(seed: int, name: str, back: Rgb, ink: Rgb, size: int = 256) -> Texture:
    """Draw a square sign that hangs out over the street: a ring of rays, a word and a number."""
    image = Image.new("RGB", (size, size), back)
    draw = ImageDraw.Draw(image)
    draw.rectangle((6, 6, size - 7, size - 7), outline=ink, width=4)
    c = size / 2
    for k in range(24):
        angle = np.pi * k / 12
        x, y = np.cos(angle), np.sin(angle)
        draw.line((c + 30 * x, 76 + 30 * y, c + 52 * x, 76 + 52 * y), ink, 3)
    fitted(draw, (c, 76), str(3 + seed), ink, (44, 34), "DejaVuSerif-Bold")
    fitted(draw, (c, 172), name, ink, (size - 34, 54), "DejaVuSerif-Bold")
    fitted(draw, (c, 218), "OPEN DAILY 7 - 18", ink, (size - 50, 22), "DejaVuSans")
    return aged(image, 120 + seed, 0.3)


def price_tags(seed: int, columns: int = 8, rows: int = 8, cell: tuple[int, int] = (128, 96)) -> Texture:
    """Draw an atlas of tags: goods, a price and a unit, on card or on slate."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (columns * cell[0], rows * cell[1]))
    draw = ImageDraw.Draw(image)
    looks = (((238, 232, 214), (150, 26, 22)), ((32, 36, 36), (236, 234, 224)), ((238, 204, 84), (22, 22, 26)))
    for k in range(columns * rows):
        back, ink = looks[k % 3]
        x, y = (k % columns) * cell[0], (k // columns) * cell[1]
        draw.rectangle((x, y, x + cell[0] - 1, y + cell[1] - 1), back)
        draw.rectangle((x + 3, y + 3, x + cell[0] - 4, y + cell[1] - 4), outline=ink, width=2)
        middle = x + cell[0] / 2
        fitted(draw, (middle, y + 20), GOODS[k % len(GOODS)], ink, (cell[0] - 20, 22), "DejaVuSans-Bold")
        price = f"{rng.integers(1, 9)}.{rng.integers(10) * 5 + 45}"
        draw.text((middle, y + 52), price, ink, font(36, "DejaVuSans-Bold"), anchor="mm")
        draw.text((middle, y + 80), ("the pound", "each", "the dozen", "a bunch")[k % 4], ink, font(13), anchor="mm")
    return aged(image, seed, 0.15)


def slate(seed: int, head: str, size: tuple[int, int] = (384, 576)) -> Texture:
    """Draw chalk on slate: a heading, a list of goods and prices, small print."""
    rng = np.random.default_rng(seed)
    width, height = size
    image = Image.new("RGB", size, (40, 44, 44))
    draw = ImageDraw.Draw(image)
    chalk, yellow = (232, 230, 220), (240, 214, 120)
    fitted(draw, (width / 2, 40), head, yellow, (width - 40, 52), "DejaVuSerif-Bold")
    draw.line((24, 74, width - 24, 74), chalk, 3)
    for k, good in enumerate(rng.permutation(len(GOODS))[:13]):
        y = 88 + 32 * k
        ink = yellow if k % 5 == 2 else chalk
        draw.text((26, y), GOODS[good], ink, font(24, "DejaVuSans"))
        draw.text((width - 26, y), f"{rng.integers(1, 20)}.{rng.integers(100):02d}", ink, font(24), anchor="ra")
        for x in range(int(40 + font(24, "DejaVuSans").getlength(GOODS[good])), width - 96, 9):
            draw.point([(x, y + 22), (x + 1, y + 22)], ink)
    for row in range(3):
        draw.text((26, height - 66 + 19 * row), speech(rng, 6), chalk, font(13, "DejaVuSans"))
    smear = fractal(1024, seed, 1.3, (1.0, 2.5))[:height, :width, None]
    return picture(np.asarray(image, float) / 255 * 0.9 + 0.1 * smear * (smear > 0.5))


def bill(seed: int, title: str, back: Rgb, ink: Rgb, size: int = 512) -> Texture:
    """Draw a play bill: a title, a picture of fine lines (rays, rings, waves or dots), lines of ever smaller type."""
    rng = np.random.default_rng(200 + seed)
    y, x = (np.mgrid[:size, :size] - np.array([[[size * 0.4]], [[size * 0.5]]])) / size
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    lines = (
        np.sin(angle * 36) * np.sign(np.sin(radius * 60)),
        np.sin(radius * 150 + 2 * np.sin(5 * angle)),
        np.sin(120 * y + 3 * np.sin(14 * x)),
        np.cos(110 * x) * np.cos(110 * y) + 1.5 - 6 * radius,
    )[seed % 4]
    shape = (np.maximum(np.abs(x), np.abs(y)) < 0.25) if seed % 2 else (radius < 0.26)
    image = Image.fromarray(np.where((shape & (lines > 0))[..., None], ink, back).astype(np.uint8))
    draw = ImageDraw.Draw(image)
    for inset, width in ((9, 4), (17, 1)):
        draw.rectangle((inset, inset, size - 1 - inset, size - 1 - inset), outline=ink, width=width)
    fitted(draw, (size / 2, size * 0.085), title, ink, (size - 60, 62), "DejaVuSerif-Bold")
    top = size * 0.7
    for points in (34, 25, 19, 15, 12, 10):
        fitted(draw, (size / 2, top), speech(rng, 3 + 60 // points), ink, (size - 52, points), "DejaVuSans")
        top += points * 1.35
    return aged(image, seed, 0.25)


def covers(seed: int, size: int = 1024, cells: int = 4) -> Texture:
    """Draw an atlas of book fronts: title, frame, ornament, a line of small type."""
    rng = np.random.default_rng(seed)
    step = size // cells
    image = Image.new("RGB", (size, size))
    draw = ImageDraw.Draw(image)
    for k in range(cells * cells):
        hue = 60 + 120 * rng.random(3) * (1.0, 0.75, 0.6)
        back: Rgb = (int(hue[0]), int(hue[1]), int(hue[2]))
        ink = (236, 214, 150) if sum(back) < 380 else (34, 26, 24)
        x, y = (k % cells) * step, (k // cells) * step
        draw.rectangle((x, y, x + step - 1, y + step - 1), back)
        for inset in (8, 14):
            draw.rectangle((x + inset, y + inset, x + step - inset, y + step - inset), outline=ink, width=2)
        c = x + step / 2
        first, _, rest = _TITLES[k % len(_TITLES)].rpartition(" ")
        fitted(draw, (c, y + 50), first or "Tales", ink, (step - 56, 34), "DejaVuSerif-Bold")
        fitted(draw, (c, y + 88), rest, ink, (step - 56, 42), "DejaVuSerif-Bold")
        for ring in range(8, 48, 5 + k % 3):
            corner = (c - ring, y + 152 - ring, c + ring, y + 152 + ring)
            (draw.ellipse if k % 2 else draw.rectangle)(corner, outline=ink, width=2)
        for row in range(2):
            fitted(draw, (c, y + 214 + 14 * row), speech(rng, 7), ink, (step - 50, 12), "DejaVuSans")
    return aged(image, seed, 0.3)


def sacking(seed: int, size: int = 512) -> tuple[Texture, Field]:
    """Return the albedo and the weave's height of a printed flour sack: coarse weave with a mill's stamp."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (size, size), (196, 172, 128))
    draw = ImageDraw.Draw(image)
    ink = (58, 66, 110)
    for k, (x, y) in enumerate(((128, 128), (384, 128), (128, 384), (384, 384))):
        draw.ellipse((x - 100, y - 92, x + 100, y + 92), outline=ink, width=5)
        draw.text((x, y - 50), ("MILL", "FARM", "PORT", "YARD")[k], ink, font(38, "DejaVuSans-Bold"), anchor="mm")
        draw.text((x, y), GOODS[int(rng.integers(20, 30))].upper(), ink, font(30, "DejaVuSerif-Bold"), anchor="mm")
        draw.text((x, y + 34), f"{rng.integers(20, 90)} LB NET", ink, font(19, "DejaVuSans"), anchor="mm")
        draw.text((x, y + 60), f"LOT {rng.integers(1000, 9999)}", ink, font(14, "DejaVuSansMono"), anchor="mm")
    y, x = np.mgrid[:size, :size]
    weave = 0.5 + 0.25 * np.sin(np.pi * x / 2) * np.where(y // 4 % 2, 1, -1) + 0.25 * np.sin(np.pi * y / 2)
    cloth = aged(image, seed, 0.35) / 255 * (0.72 + 0.35 * weave[..., None])
    return picture(cloth), weave
