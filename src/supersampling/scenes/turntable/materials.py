"""Materials of the studio: engraved bronze, carved stone and wood, and the sheets on the walls."""

from functools import cache

import numpy as np
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter

from supersampling.scenes.kit import lettering, metal, textures
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.dials import gauge
from supersampling.scenes.kit.textures import Field, Maps
from supersampling.scenes.scene import Material

BANDS = ("* THE WHEEL TURNS AND THE EYE STANDS STILL *", "* WHAT WAS HIDDEN COMES ROUND AGAIN *")
PANELS = ("AD MCMLXXI", "OPUS XII", "SOL ET LUNA", "FECIT RASTER")
Stops = list[tuple[float, float, float]]


def _height_of(size: int, image: Image.Image, blur: float) -> Field:
    """Return the height field of a drawing of twice the size."""
    small = image.resize((size, size), Image.Resampling.BOX)
    return np.asarray(gaussian_filter(np.asarray(small, float) / 255, blur, mode="wrap"))


def scrolls(size: int, cells: int) -> Field:
    """Return the height field of carved scrolls: spirals in alternating directions, leaves, a bead in each eye."""
    big = 2 * size
    image = Image.new("L", (big, big), 0)
    draw, step = ImageDraw.Draw(image), big / cells
    t = np.linspace(0, 5.2 * np.pi, 160)
    for i in range(cells):
        for j in range(-1, cells + 1):
            sense = 1 if (i + j) % 2 else -1
            radius = step * (0.06 + 0.41 * t / t[-1])
            x = (j + 0.5) * step + radius * np.cos(sense * t + 0.5 * np.pi)
            y = (i + 0.5) * step + radius * np.sin(sense * t + 0.5 * np.pi)
            draw.line(list(zip(x, y)), 235, max(int(step / 13), 2), joint="curve")
            for k in range(60, 160, 14):
                reach = 0.055 * step
                out = np.array([x[k] - (j + 0.5) * step, y[k] - (i + 0.5) * step])
                tip = np.array([x[k], y[k]]) + out / np.linalg.norm(out) * reach
                draw.ellipse((tip[0] - reach, tip[1] - reach / 2, tip[0] + reach, tip[1] + reach / 2), 170)
            eye = 0.07 * step
            middle = ((j + 0.5) * step, (i + 0.5) * step)
            draw.ellipse((middle[0] - eye, middle[1] - eye, middle[0] + eye, middle[1] + eye), 255)
    return _height_of(size, image, size / 700)


def engraved_lines(size: int, waves: int) -> Field:
    """Return a guilloche: two families of fine waves that cross, cut into a flat ground."""
    y, x = np.mgrid[:size, :size] / size
    height = np.ones((size, size))
    for sense in (-1, 1):
        phase = y * waves + sense * 1.6 * np.sin(2 * np.pi * 4 * x) + 0.5 * np.sin(2 * np.pi * 12 * x)
        height -= 0.6 * np.exp(-(((phase % 1) - 0.5) ** 2) / 0.012)
    return height


def raised_letters(text: str, width: int, height: int, points: int, repeats: int) -> Field:
    """Return the height field of a band: raised letters between two fillets, ``text`` in each of its equal parts."""
    image = Image.new("L", (2 * width, 2 * height), 60)
    draw, letters = ImageDraw.Draw(image), lettering.font(2 * points, "DejaVuSerif-Bold")
    for k in range(repeats):
        draw.text((2 * width * (k + 0.5) / repeats, height), text, 255, letters, anchor="mm")
    for y in (6, 2 * height - 14):
        draw.rectangle((0, y, 2 * width, y + 7), 220)
    return np.asarray(image.resize((width, height), Image.Resampling.BOX), float) / 255


def scale_ring(width: int, height: int) -> Field:
    """Return the height field of a scale of degrees, a full turn wide: ticks, and a number at every ten."""
    image = Image.new("L", (2 * width, 2 * height), 255)
    draw, letters = ImageDraw.Draw(image), lettering.font(height // 2, "DejaVuSans-Bold")
    for degree in range(360):
        x = 2 * width * (degree + 0.5) / 360
        reach = 0.62 if degree % 10 == 0 else 0.42 if degree % 5 == 0 else 0.28
        draw.line((x, 0, x, 2 * height * reach), 20, 4 if degree % 5 else 7)
        if degree % 10 == 0:
            draw.text((x, 2 * height * 0.82), str(degree), 20, letters, anchor="mm")
    return np.asarray(image.resize((width, height), Image.Resampling.BOX), float) / 255


@cache
def _weather() -> tuple[Field, Field]:
    """Return fine and coarse noise, 1024 x 1024."""
    return textures.fractal(1024, 1, 0.35), textures.fractal(1024, 2, 1.2)


def carved(relief: Field, seed: int, stops: Stops, depth: float, metallic: float, rough: float = 0.35) -> Maps:
    """Return the maps of a relief: dull in its hollows (patina, dust), worn bright on its heights."""
    height, width = relief.shape
    shift = tuple(np.random.default_rng(seed).integers(1024, size=2))
    across = max(width // 1024, 1)
    grain, cloud = (np.tile(np.roll(f, shift, (0, 1)), (1, across))[:height, :width] for f in _weather())
    tone = np.clip(0.12 + 0.62 * relief + 0.3 * (grain - 0.5) + 0.25 * (cloud - 0.5), 0, 1)
    hollow = np.clip(1.2 - 1.8 * relief, 0, 1) * (0.6 + 0.6 * cloud)
    surface = textures.surface(
        np.clip(rough + 0.3 * grain + 0.35 * hollow, 0, 1), metallic * (1 - 0.7 * np.clip(hollow, 0, 1))
    )
    return (textures.picture(textures.ramp(tone, stops)), textures.normals(relief + 0.06 * grain, depth), surface)


class Materials:
    """Materials of the studio, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        bronze: Stops = [(0.16, 0.22, 0.18), (0.42, 0.3, 0.16), (0.76, 0.55, 0.28), (0.95, 0.8, 0.52)]
        ivory: Stops = [(0.3, 0.25, 0.18), (0.66, 0.59, 0.47), (0.86, 0.81, 0.7)]
        oak: Stops = [(0.14, 0.08, 0.05), (0.36, 0.21, 0.12), (0.55, 0.37, 0.22)]
        steel: Stops = [(0.18, 0.18, 0.19), (0.5, 0.5, 0.51), (0.82, 0.82, 0.8)]
        dark: Stops = [(0.13, 0.13, 0.14), (0.26, 0.26, 0.27), (0.4, 0.39, 0.38)]
        plaster: Stops = [(0.3, 0.36, 0.37), (0.42, 0.48, 0.48), (0.54, 0.59, 0.57)]
        red: Stops = [(0.32, 0.15, 0.1), (0.55, 0.28, 0.2), (0.7, 0.44, 0.33)]
        marble = ([(0.42, 0.39, 0.35), (0.7, 0.66, 0.6)], [(0.16, 0.15, 0.16), (0.32, 0.29, 0.3)])
        self.bronze = self._maps("bronze", carved(engraved_lines(512, 24), 1, bronze, 2.0, 1.0), 0.24)
        self.scrolls = self._maps("bronze scrolls", carved(scrolls(1024, 5), 5, bronze, 7.0, 1.0), 0.75)
        self.stone = self._maps("carved stone", carved(scrolls(768, 6), 9, ivory, 8.0, 0.0, 0.6), 0.7)
        self.plain = self._maps("smooth stone", textures.stone(512, 13, ivory, 1), 0.9)
        self.oak = self._maps("oak", textures.wood(512, 17, oak), 0.7)
        self.steel = self._maps("steel", metal.brushed(512, 21, steel), 0.4)
        self.iron = self._maps("iron", metal.brushed(256, 25, dark, 0.3), 0.5)
        self.scale = self._maps("scale", carved(scale_ring(4096, 128), 29, bronze, 2.5, 1.0, 0.3), 1.0)
        self.bands = [
            self._maps(
                f"band {k}", carved(raised_letters(t, 2048, 128, 62, 1), 33 + k, (bronze, ivory)[k], 5.0, 1.0 - k), 1.0
            )
            for k, t in enumerate(BANDS)
        ]
        self.panels = [
            self._maps(f"panel {k}", carved(raised_letters(t, 512, 256, 62, 1), 37 + k, bronze, 4.0, 1.0), 1.0)
            for k, t in enumerate(PANELS)
        ]
        self.brick = self._maps("brick", textures.bricks(512, 16, 6, red, 41), 1.4)
        self.plaster = self._maps("wall paper", carved(1 - 0.6 * scrolls(512, 8), 45, plaster, 1.5, 0.0, 0.7), 1.2)
        self.tiles = self._maps("tiles", textures.floor_tiles(512, 6, marble, 49), 2.0)
        self.spines = self._flat("book spines", lettering.spines(51), 0.65)
        self.paper = self._flat("newspaper", lettering.newspaper(4), 0.9)
        posters = (
            ("GUILLOCHE", (28, 52, 70), (236, 222, 180)),
            ("TURNED WORK", (226, 208, 166), (130, 34, 28)),
            ("ROSE ENGINE", (60, 84, 62), (240, 228, 196)),
            ("PATTERN NO 9", (190, 150, 70), (30, 26, 26)),
        )
        self.posters = [self._flat(t, lettering.poster(k, b, f, t), 0.8) for k, (t, b, f) in enumerate(posters)]
        self.gauges = [self._flat(u, gauge(k, u), 0.5) for k, u in enumerate(("rpm", "mm"))]
        self.plan = self._flat("work plan", lettering.notice(6, "WORK PLAN", (212, 222, 226), (26, 44, 90)), 0.9)
        soft = np.full((8, 8, 3), 235, np.uint8)
        self.lamp = builder.material(Material("soft box", soft, roughness=0.9, emission=(3.2, 3.0, 2.6)))

    def _maps(self, name: str, maps: Maps, tile: float) -> int:
        return self._builder.material(Material(name, *maps, roughness=1.0, metallic=1.0), tile)

    def _flat(self, name: str, albedo: np.ndarray, roughness: float) -> int:
        return self._builder.material(Material(name, albedo, roughness=roughness))
