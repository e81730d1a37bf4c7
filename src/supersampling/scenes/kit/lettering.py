"""Textures that carry text: newspapers, posters, book spines, labels and signs (DejaVu fonts of matplotlib)."""

from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from supersampling.scenes.kit.textures import fractal, picture
from supersampling.scenes.scene import Texture

Rgb = tuple[int, int, int]

_VOCABULARY = (
    "light sample pixel frame motion vector depth edge window shadow mirror column arch stone river garden engine "
    "filter kernel history jitter phase signal grid lattice aperture lens shutter exposure contrast detail texture "
    "surface normal gradient moment error estimate weight recurrent network layer buffer colour radiance of the and "
    "in a to with over under between after before while without toward from each every one two seven eleven forty "
    "moves stands turns falls rises carries keeps returns samples resolves blends rejects clamps warps measures"
)
_WORDS = _VOCABULARY.split()
_TITLES = (
    "Treatise on Light", "Sampling Theory", "The Aliased Garden", "Fields of View", "A Lens for All", "Motion & Memory",
    "Eleven Columns", "Nyquist at Sea", "The Slow Shutter", "Optics II", "Moire", "Lattices", "On Gradients", "Edges",
    "History of Frames", "Twelve Filters", "Convolutions", "The Iron Arch", "Depth", "Wave and Grain", "Atlas of Noise",
    "Phase", "Small Kernels", "Jittered Paths", "The Last Pixel", "Subpixel Tales", "Spectra", "Residuals",
    "Warped Time", "Quiet Machines", "Light Transport", "Stone & Brick",
)  # fmt: skip


@cache
def font(size: int, face: str = "DejaVuSerif") -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"{face}.ttf"), size)


def _prose(rng: np.random.Generator, words: int) -> str:
    text = [_WORDS[i] for i in rng.integers(len(_WORDS), size=words)]
    for i in range(0, words, 9):
        text[i] = text[i].capitalize()
        text[i - 1] += "."
    return " ".join(text)


def _fill(
    draw: ImageDraw.ImageDraw, box: tuple[int, int, int, int], text: str, size: int, color: Rgb, face: str
) -> None:
    """Wrap ``text`` into ``box`` (left, top, right, bottom), repeating it until the box is full."""
    letters, words, i = font(size, face), text.split(), 0
    space = letters.getlength(" ")
    for y in range(box[1], box[3] - size, round(size * 1.22)):
        line, length = [], 0.0
        while length + letters.getlength(words[i % len(words)]) < box[2] - box[0]:
            line.append(words[i % len(words)])
            length += letters.getlength(line[-1]) + space
            i += 1
        draw.text((box[0], y), " ".join(line), color, letters)


def aged(image: Image.Image, seed: int, amount: float = 0.25) -> Texture:
    """Multiply paper grain into a drawing."""
    pixels = np.asarray(image, float) / 255
    side = max(image.size)
    grain = fractal(side, seed, 0.5)[: image.size[1], : image.size[0], None]
    return picture(pixels * (1 - amount + amount * 1.4 * grain))


def newspaper(seed: int, size: int = 1024) -> Texture:
    """Draw a front page: masthead, headline, four columns of small type, a halftone picture."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (size, size), (226, 217, 196))
    draw, ink = ImageDraw.Draw(image), (28, 26, 24)
    name = ("THE DAILY SAMPLE", "ATRIUM GAZETTE", "FRAME & FIELD", "MORNING RASTER")[seed % 4]
    draw.text((size // 2, 28), name, ink, font(84, "DejaVuSerif-Bold"), anchor="ma")
    draw.line((24, 138, size - 24, 138), ink, 4)
    draw.text((30, 144), f"No. {1000 + seed * 37}   {_prose(rng, 9)}", ink, font(20))
    draw.line((24, 174, size - 24, 174), ink, 2)
    draw.text((size // 2, 184), _prose(rng, 3).upper().rstrip("."), ink, font(54, "DejaVuSans-Bold"), anchor="ma")
    width = (size - 60) // 4
    y, x = np.mgrid[:230, : 2 * width - 16]
    tone = fractal(1024, seed + 9, 1.4)[: y.shape[0], : y.shape[1]]
    dots = np.where(np.hypot(x % 8 - 3.5, y % 8 - 3.5) < 5.4 * tone, 40, 220).astype(np.uint8)
    image.paste(Image.fromarray(dots).convert("RGB"), (30 + width, 262))
    for i in range(4):
        left, top = 30 + i * width, 508 if i in (1, 2) else 262
        draw.text((left, top), _prose(rng, 2), ink, font(24, "DejaVuSerif-Bold"))
        _fill(
            draw,
            (left, top + 34, left + width - 16, size - 30),
            _prose(rng, 150),
            (15, 12, 18, 13)[i],
            ink,
            "DejaVuSerif",
        )
        draw.line((left + width - 9, 262, left + width - 9, size - 30), ink, 1)
    return aged(image, seed)


def poster(seed: int, back: Rgb, front: Rgb, title: str, size: int = 512) -> Texture:
    """Draw a poster: rings of spokes (a resolution chart), a title and lines of ever smaller type."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:size, :size] - np.array([[[size * 0.42]], [[size * 0.5]]])
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    spokes = (np.sin(angle * (24 + 12 * (seed % 3)) + radius * 0.04 * (seed % 2)) > 0) ^ ((radius // 22) % 2 > 0)
    chart = (spokes & (radius < size * 0.3))[..., None]
    image = Image.fromarray(np.where(chart, front, back).astype(np.uint8))
    draw = ImageDraw.Draw(image)
    draw.rectangle((8, 8, size - 9, size - 9), outline=front, width=4)
    draw.text((size // 2, 16), title, front, font(44, "DejaVuSans-Bold"), anchor="ma")
    top = int(size * 0.74)
    for points in (30, 22, 16, 12, 9):
        draw.text((size // 2, top), _prose(rng, 3 + 66 // points), front, font(points, "DejaVuSans"), anchor="ma")
        top += round(points * 1.35)
    return aged(image, seed, 0.2)


def inscription(text: str, width: int, height: int, points: int, seed: int) -> tuple[Texture, np.ndarray]:
    """Return the albedo and the height field of text cut into stone, fitted to the whole width."""
    image = Image.new("L", (width, height), 255)
    draw, letters = ImageDraw.Draw(image), font(points, "DejaVuSerif-Bold")
    draw.text((width // 2, height // 2), text, 0, letters, anchor="mm")
    for y in (4, height - 7):
        draw.line((0, y, width, y), 60, 3)
    cut = np.asarray(image, float) / 255
    side = max(width, height)
    grain = fractal(side, seed, 0.5)[:height, :width]
    stone = np.array([0.78, 0.71, 0.6]) * (0.6 + 0.6 * grain[..., None])
    return picture(stone * (0.3 + 0.7 * cut[..., None])), cut + 0.15 * grain


def spines(seed: int, size: int = 1024, columns: int = 16, rows: int = 4) -> Texture:
    """Draw an atlas of book spines, ``columns x rows``, each with a title that runs down it and gilded bands."""
    rng = np.random.default_rng(seed)
    width, height = size // columns, size // rows
    image = Image.new("RGB", (size, size))
    for k in range(columns * rows):
        hue = 0.12 + 0.6 * (0.6 * rng.random() + 0.4 * rng.random(3) * (1.0, 0.75, 0.6))
        back = tuple(int(255 * v) for v in hue * rng.uniform(0.5, 1.25))
        ink = (235, 205, 120) if sum(back) < 330 else (30, 22, 18)
        book = Image.new("RGB", (height, width), back)
        draw = ImageDraw.Draw(book)
        for x in (10, 16, height - 18, height - 12, height // 5 * 4):
            draw.line((x, 0, x, width), ink, 2)
        title = _TITLES[int(rng.integers(len(_TITLES)))]
        points = min(30, int(30 * (height * 0.68) / font(30).getlength(title)))
        draw.text((26, width // 2), title, ink, font(points, ("DejaVuSerif-Bold", "DejaVuSans")[k % 2]), anchor="lm")
        draw.text((height - 42, width // 2), str(k + 1), ink, font(16), anchor="lm")
        image.paste(book.rotate(-90, expand=True), ((k % columns) * width, (k // columns) * height))
    return aged(image, seed, 0.35)


def banner(seed: int, back: Rgb, front: Rgb, word: str, width: int = 256, height: int = 1024) -> Texture:
    """Draw a woven hanging banner: a border of triangles, a word that runs down it letter by letter, and small type."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (width, height), back)
    draw = ImageDraw.Draw(image)
    for y in range(0, height, 16):
        draw.polygon([(0, y), (16, y + 8), (0, y + 16)], front)
        draw.polygon([(width, y), (width - 16, y + 8), (width, y + 16)], front)
    step = (height - 260) // max(len(word), 1)
    for i, letter in enumerate(word):
        draw.text((width // 2, 40 + i * step), letter, front, font(min(step, 130), "DejaVuSerif-Bold"), anchor="ma")
    _fill(draw, (26, height - 200, width - 26, height - 20), _prose(rng, 80), 15, front, "DejaVuSans")
    y, x = np.mgrid[:height, :width]
    weave = 0.8 + 0.2 * ((x // 2 + y // 2) % 2)
    return picture(np.asarray(aged(image, seed, 0.2), float) / 255 * weave[..., None])


def label_sheet(seed: int, size: int = 1024, cells: int = 4) -> Texture:
    """Draw an atlas of ``cells x cells`` crate sides: planks with a printed label, a bar code and small type."""
    rng = np.random.default_rng(seed)
    step = size // cells
    image = Image.new("RGB", (size, size))
    for k in range(cells * cells):
        side = Image.new("RGB", (step, step), (168, 128, 82))
        draw = ImageDraw.Draw(side)
        for y in range(0, step, step // 6):
            draw.line((0, y, step, y), (70, 48, 30), 3)
        draw.rectangle((3, 3, step - 4, step - 4), outline=(92, 62, 36), width=9)
        back = ((240, 236, 222), (236, 190, 60), (196, 52, 40), (60, 110, 160))[k % 4]
        ink = (20, 20, 20) if k % 4 < 2 else (245, 240, 230)
        draw.rectangle((34, 44, step - 34, step - 44), back)
        draw.text((42, 48), f"LOT {rng.integers(100, 999)}", ink, font(38, "DejaVuSans-Bold"))
        draw.text((42, 94), ("FRAGILE", "THIS SIDE UP", "NO HOOKS", "KEEP DRY")[k // 4], ink, font(24, "DejaVuSans"))
        _fill(draw, (42, 126, step - 40, step - 74), _prose(rng, 30), 12, ink, "DejaVuSansMono")
        x = 42
        while x < step - 50:
            bar = int(rng.integers(1, 5))
            draw.rectangle((x, step - 72, x + bar - 1, step - 48), ink)
            x += bar + int(rng.integers(2, 5))
        image.paste(side, ((k % cells) * step, (k // cells) * step))
    return aged(image, seed, 0.35)


def notice(seed: int, head: str, back: Rgb, ink: Rgb, size: int = 512) -> Texture:
    """Draw a sign or a plan: a heading, rules in several sizes, a table of figures."""
    rng = np.random.default_rng(seed)
    image = Image.new("RGB", (size, size), back)
    draw = ImageDraw.Draw(image)
    draw.rectangle((6, 6, size - 7, size - 7), outline=ink, width=5)
    draw.text((size // 2, 18), head, ink, font(50, "DejaVuSans-Bold"), anchor="ma")
    _fill(draw, (22, 84, size - 20, 170), _prose(rng, 40), 22, ink, "DejaVuSans-Bold")
    _fill(draw, (22, 172, size - 20, 270), _prose(rng, 80), 14, ink, "DejaVuSans")
    for row in range(10):
        y = 276 + row * 22
        draw.line((22, y, size - 22, y), ink, 1)
        for column in range(6):
            draw.text((28 + column * 78, y + 3), f"{rng.random() * 900:.2f}", ink, font(15, "DejaVuSansMono"))
    return aged(image, seed, 0.2)
