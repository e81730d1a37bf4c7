"""Glossy textures of the bar: polished stone, glazed tiles, lacquer, leather, pressed tin, lit glass and signs."""

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw

from supersampling.scenes.kit.lettering import Rgb, font
from supersampling.scenes.kit.textures import Field, Maps, fractal, masonry, normals, picture, ramp, surface
from supersampling.scenes.scene import Texture


def _leaning(height: Field, strength: float, tilt: tuple[Field, Field], most: float) -> Texture:
    """Return the normal map of a height field whose stones lean by up to ``most`` (slope).

    The lean is proportional to the random value ``tilt`` of a stone, in [0, 1].
    """
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2 * strength + most * (2 * tilt[0] - 1)
    dy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2 * strength + most * (2 * tilt[1] - 1)
    normal = np.stack([-dx, dy, np.ones_like(dx)], -1)
    return picture(normal / np.linalg.norm(normal, axis=-1, keepdims=True) * 0.5 + 0.5)


def checkers(size: int, count: int, seed: int) -> Maps:
    """Draw polished black and cream marble in squares that do not lie quite level, with smears of wiping."""
    inside, value, height = masonry(size, count, count, 0.003, seed, 0.0)
    shifted = np.roll(value, size // count, 0)
    y, x = np.mgrid[:size, :size] / size * count
    light = (np.floor(x) + np.floor(y)) % 2 > 0.5
    cloud, fine, wave = (fractal(size, seed + 5, 1.25), fractal(size, seed + 6, 1.0), fractal(size, seed + 8, 2.4))
    vein = np.clip(1 - np.abs(((cloud * 4 + fine + value * 3) % 1) - 0.5) * 12, 0, 1)
    tone = np.clip(0.3 * value + 0.7 * fine, 0, 1)
    cream = ramp(tone, [(0.5, 0.44, 0.36), (0.72, 0.66, 0.56)]) - 0.22 * vein[..., None] * [0.7, 0.9, 1.1]
    black = ramp(tone, [(0.11, 0.1, 0.115), (0.18, 0.17, 0.18)]) + 0.26 * vein[..., None] * [1.0, 0.9, 0.75]
    color = np.where(light[..., None], cream, black)
    color = np.where(inside[..., None] > 0.5, color, 0.17)
    smear = fractal(size, seed + 7, 1.0, (2.0, 0.5))
    shine = 0.1 + 0.18 * smear**2 + 0.04 * light + 0.5 * (1 - inside)
    return picture(color), _leaning(0.6 * height + 3.0 * wave, 3.0, (value, shifted), 0.01), surface(shine)


def glazed(size: int, rows: int, columns: int, stops: Sequence[Sequence[float]], seed: int) -> Maps:
    """Draw hand-made glazed tiles: rounded edges, pooled colour, each tile tilted in its own direction."""
    inside, value, height = masonry(size, rows, columns, 0.006, seed)
    shifted = np.roll(value, 2 * size // rows, 0)
    pool = fractal(size, seed + 3, 1.9)
    tone = np.clip(0.55 * value + 0.5 * pool + 0.25 * (height - 1), 0, 1)
    color = inside[..., None] * ramp(tone, stops) + (1 - inside[..., None]) * 0.3
    normal = _leaning(height + 0.5 * pool, 4.0, (value, shifted), 0.05)
    return picture(color), normal, surface(0.1 + 0.1 * pool + 0.6 * (1 - inside))


def veneer(size: int, seed: int, stops: Sequence[Sequence[float]]) -> Maps:
    """Draw figured wood without joints, its grain along u, under a mirror of lacquer with rings left by wet glasses."""
    warp, fibre = fractal(size, seed, 2.1, (0.6, 4.0)), fractal(size, seed + 1, 0.9, (0.5, 14.0))
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * 7 * warp)
    smear, wave = fractal(size, seed + 2, 0.9), fractal(size, seed + 3, 2.4)
    y, x = np.mgrid[:size, :size] / size
    wet = np.zeros((size, size))
    for u, v in np.random.default_rng(seed).uniform(0.1, 0.9, (6, 2)):
        wet += np.exp(-(((np.hypot(x - u, y - v) - 0.05) / 0.004) ** 2))
    color = ramp(np.clip(0.45 * rings + 0.5 * fibre, 0, 1), stops)
    return (
        picture(color),
        normals(2 * wave + 0.02 * wet, 2.0),
        surface(0.11 + 0.2 * smear**2 + 0.12 * np.clip(wet, 0, 1)),
    )


def polished(size: int, seed: int, stops: Sequence[Sequence[float]], least: float = 0.12) -> Maps:
    """Draw polished metal with finger marks and a soft dent or two."""
    mark, cloud, line = (
        fractal(size, seed, 1.0),
        fractal(size, seed + 1, 2.2),
        fractal(size, seed + 2, 0.5, (1.0, 9.0)),
    )
    tone = np.clip(0.25 + 0.4 * cloud + 0.3 * line, 0, 1)
    shine = least + 0.16 * mark**2 + 0.06 * line
    return picture(ramp(tone, stops)), normals(cloud + 0.02 * line, 2.0), surface(shine, 1.0)


def tufted(size: int, seed: int, stops: Sequence[Sequence[float]], cells: int = 4) -> Maps:
    """Draw buttoned leather: diamonds that bulge between buttons."""
    y, x = np.mgrid[:size, :size] / size * cells
    u, v = x + y, x - y
    bulge = np.abs(np.sin(np.pi * u) * np.sin(np.pi * v)) ** 0.4
    corner = np.hypot((u + 0.5) % 1 - 0.5, (v + 0.5) % 1 - 0.5)
    button = np.clip(1 - corner / 0.12, 0, 1) ** 0.5
    grain, cloud = fractal(size, seed, 0.35), fractal(size, seed + 1, 1.1)
    color = ramp(np.clip(0.25 + 0.35 * bulge + 0.3 * cloud + 0.2 * grain, 0, 1), stops)
    return (picture(color), normals(1.6 * bulge + 0.8 * button + 0.02 * grain, 7.0), surface(0.24 + 0.18 * grain))


def pressed_tin(size: int, seed: int, cells: int = 2) -> Maps:
    """Draw copper-coloured ceiling plates: a rosette in every square, a rope along its edge."""
    y, x = np.mgrid[:size, :size] / size * cells
    u, v = x % 1 - 0.5, y % 1 - 0.5
    radius, angle = np.hypot(u, v), np.arctan2(v, u)
    petals = np.clip(1 - radius / (0.3 + 0.07 * np.cos(8 * angle)), 0, 1) ** 0.5
    ringed = np.exp(-(((radius - 0.4) / 0.02) ** 2)) + np.exp(-((radius / 0.06) ** 2))
    edge = np.minimum(0.5 - np.abs(u), 0.5 - np.abs(v))
    frame = np.exp(-(((edge - 0.035) / 0.015) ** 2))
    height = petals * (0.8 + 0.2 * np.cos(8 * angle)) + ringed + frame
    cloud, mark = fractal(size, seed, 1.1), fractal(size, seed + 1, 0.8)
    color = ramp(
        np.clip(0.2 + 0.3 * height + 0.4 * cloud, 0, 1), [(0.36, 0.19, 0.12), (0.75, 0.47, 0.32), (0.93, 0.68, 0.5)]
    )
    return picture(color), normals(height, size / 90), surface(0.24 + 0.18 * mark, 1.0)


def fans(size: int, seed: int, stops: Sequence[Sequence[float]], cells: int = 2) -> Maps:
    """Draw wall covering of overlapping fans: gilded ribs and arcs on a satin ground."""
    y, x = np.mgrid[:size, :size] / size * cells
    figure, shade = np.zeros((size, size)), np.zeros((size, size))
    # Lower rows of fans lie over the higher ones; a fan is a disc about its foot.
    for row in range(-1, 2 * cells + 2):
        u = (x + 0.5 * (row % 2)) % 1 - 0.5
        v = y - 0.5 * row
        radius, angle = np.hypot(u, v), np.arctan2(-v, u)
        inside = (radius < 0.5) & (v < 0.25)
        arcs = np.clip((0.045 - np.abs(radius - 0.46)) * 40, 0, 1) + np.clip((0.03 - np.abs(radius - 0.33)) * 40, 0, 1)
        ribs = np.clip((np.cos(10 * angle) - 0.55) * 5, 0, 1) * ((radius > 0.08) & (radius < 0.27))
        figure = np.where(inside, np.clip(arcs + ribs, 0, 1), figure)
        shade = np.where(inside, 1 - radius, shade)
    cloud = fractal(size, seed, 0.9)
    gold = ramp(cloud, [(0.45, 0.3, 0.16), (0.84, 0.63, 0.36)])
    color = ramp(np.clip(0.1 + 0.5 * cloud + 0.5 * shade, 0, 1), stops)
    color += figure[..., None] * (gold - color)
    return (
        picture(color),
        normals(0.5 * figure + 0.4 * shade, 2.0),
        surface(0.36 - 0.1 * figure + 0.06 * cloud, 0.9 * figure),
    )


def onyx(size: int, seed: int) -> Maps:
    """Draw onyx that is lit from behind."""
    cloud, fine = fractal(size, seed, 2.0, (0.7, 1.6)), fractal(size, seed + 1, 1.5)
    height = fractal(size, seed + 2, 2.2)
    band = 0.5 + 0.5 * np.sin(2 * np.pi * (4 * cloud + 0.3 * fine))
    color = ramp(np.clip(0.7 * band + 0.3 * fine, 0, 1), [(0.42, 0.13, 0.03), (0.85, 0.45, 0.12), (0.98, 0.8, 0.45)])
    return picture(color), normals(height, 1.5), surface(0.12 + 0.1 * fine, 0.0, 0.3 + 0.7 * band)


def night_town(width: int, height: int, seed: int) -> Texture:
    """Draw a town at night behind glass: towers with lit rooms, street lamps out of focus, a glow above the roofs."""
    rng = np.random.default_rng(seed)
    share = np.linspace(0, 1, height)[:, None, None]
    sky = (1 - share) * np.array([8, 10, 30]) + share * np.array([70, 36, 62])
    image = Image.fromarray(np.broadcast_to(sky, (height, width, 3)).astype(np.uint8))
    draw = ImageDraw.Draw(image)
    for depth in range(3):
        x = -20
        while x < width:
            wide, top = int(rng.integers(36, 90)), int(height * (0.2 + 0.16 * depth + 0.3 * rng.random()))
            back = tuple(int(v * (1 - 0.25 * depth)) for v in (26, 24, 44))
            draw.rectangle((x, top, x + wide, height), back)
            for row in range(top + 8, height - 4, 11):
                for column in range(x + 5, x + wide - 7, 10):
                    if rng.random() < 0.3:
                        lamp = ((255, 196, 110), (255, 226, 170), (150, 190, 255))[int(rng.integers(3))]
                        shade = rng.uniform(0.25, 0.9)
                        draw.rectangle((column, row, column + 4, row + 6), tuple(int(v * shade) for v in lamp))
            x += wide + int(rng.integers(2, 16))
    glow = np.zeros((height, width, 3))
    v, u = np.mgrid[-22:22, -22:22]
    for _ in range(46):
        x, y, radius = (int(rng.integers(22, width - 22)), int(height * rng.uniform(0.55, 0.9)), rng.uniform(7, 20))
        hue = np.array(((255, 120, 40), (255, 60, 90), (90, 220, 255), (255, 220, 150))[int(rng.integers(4))])
        disc = np.clip(radius - np.hypot(u, v), 0, 1) * rng.uniform(0.25, 0.7)
        glow[y - 22 : y + 22, x - 22 : x + 22] += disc[..., None] * hue
    return picture((np.asarray(image) + glow) / 255)


def lit_sign(
    text: str, small: str, back: Rgb, front: Rgb, width: int = 512, height: int = 192
) -> tuple[Texture, Texture]:
    """Draw the face of a light box and its surface map: letters and border glow, the ground a little."""
    image, mask = Image.new("RGB", (width, height), back), Image.new("L", (width, height), 40)
    for draw, ink in ((ImageDraw.Draw(image), front), (ImageDraw.Draw(mask), 255)):
        draw.rounded_rectangle((8, 8, width - 9, height - 9), 20, outline=ink, width=6)
        points = min(96, int(96 * (width - 60) / font(96, "DejaVuSans-Bold").getlength(text)))
        draw.text((width / 2, height * 0.43), text, ink, font(points, "DejaVuSans-Bold"), anchor="mm")
        draw.text((width / 2, height * 0.79), small, ink, font(26, "DejaVuSans"), anchor="mm")
    return np.asarray(image), surface(np.full((height, width), 0.2), 0.0, np.asarray(mask) / 255)


def labels(seed: int, size: int = 512, cells: int = 4) -> Texture:
    """Draw a sheet of bottle labels, ``cells x cells``."""
    rng, step = np.random.default_rng(seed), size // cells
    image = Image.new("RGB", (size, size))
    names = ("RYE", "No. 7", "AMARO", "GIN", "ABSINTHE", "RHUM", "CASSIS", "MEZCAL")
    for k in range(cells * cells):
        back = ((236, 226, 198), (24, 22, 26), (150, 26, 30), (222, 176, 80))[int(rng.integers(4))]
        ink = (30, 22, 20) if sum(back) > 400 else (232, 206, 140)
        label = Image.new("RGB", (step, step), back)
        draw = ImageDraw.Draw(label)
        for y in (8, 14, step - 15, step - 9):
            draw.line((0, y, step, y), ink, 2)
        for x in (step // 4, 3 * step // 4):
            draw.text((x, step * 0.42), names[k % 8], ink, font(17, "DejaVuSerif-Bold"), anchor="mm")
            draw.text((x, step * 0.68), f"est. {1820 + 7 * k}", ink, font(9), anchor="mm")
        image.paste(label, (k % cells * step, k // cells * step))
    return np.asarray(image)
