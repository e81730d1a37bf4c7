"""Materials of the arena: sand, stone, robots' paint, signs in the world, and the elements of the interface."""

from dataclasses import replace

import numpy as np

from supersampling.scenes.arena import interface
from supersampling.scenes.arena.figures import Coat
from supersampling.scenes.kit import lettering, metal, textures
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.lettering import Rgb
from supersampling.scenes.scene import Material, Texture

SHINE = 1.6  # emission of the interface: white comes out as 0.95 on the screen
COATS = (
    ((0.3, 0.07, 0.05), (0.6, 0.16, 0.1), (0.76, 0.34, 0.22)),
    ((0.08, 0.16, 0.34), (0.16, 0.32, 0.58), (0.4, 0.54, 0.72)),
    ((0.46, 0.3, 0.06), (0.76, 0.55, 0.14), (0.9, 0.76, 0.4)),
    ((0.12, 0.26, 0.2), (0.24, 0.46, 0.34), (0.46, 0.64, 0.5)),
    ((0.42, 0.42, 0.4), (0.66, 0.65, 0.6), (0.84, 0.82, 0.76)),
    ((0.2, 0.14, 0.24), (0.38, 0.26, 0.44), (0.58, 0.46, 0.62)),
)
FIGURES: tuple[tuple[str, str, int, tuple[int, int], Rgb], ...] = (
    ("OLD TOLLER", "warden of the ring, iron", 31, (5230, 6400), interface.GOLD),
    ("MARROW-9", "red forge, lancer", 17, (412, 1800), interface.BAD),
    ("KESTREL", "blue yard, lancer", 19, (1640, 1900), interface.POWER),
    ("BRASS AUNT", "red forge, shield", 22, (1210, 2400), interface.BAD),
    ("FINCH", "blue yard, mender", 12, (980, 1100), interface.POWER),
    ("TIN SEXTON", "red forge, shield", 14, (655, 1500), interface.BAD),
    ("DUNE TICK", "wild, six legs", 8, (300, 420), interface.GOOD),
    ("SALT TICK", "wild, six legs", 9, (96, 460), interface.GOOD),
)


def trodden(size: int, seed: int, stops: list[tuple[float, float, float]]) -> textures.Maps:
    """Draw sand with gravel, damp patches, rake marks and footprints."""
    grit = np.tile(textures.photo("gravel"), (size // 512, size // 512))
    cloud, damp = textures.fractal(size, seed, 1.2), textures.fractal(size, seed + 1, 1.0)
    y, x = np.mgrid[:size, :size] / size
    rake = 0.5 + 0.5 * np.sin(2 * np.pi * (40 * x + 3 * np.sin(2 * np.pi * y) + 2 * cloud))
    prints, rng = np.zeros((size, size)), np.random.default_rng(seed)
    step = size // 40
    v, u = np.mgrid[-step : step + 1, -step : step + 1] / step
    for _ in range(150):
        a = rng.uniform(0, 2 * np.pi)
        along, across = np.cos(a) * u + np.sin(a) * v, np.cos(a) * v - np.sin(a) * u
        sole = np.clip(1.3 - np.hypot(along / 0.8, across / 0.36), 0, 1) * (0.7 + 0.3 * np.sign(np.sin(along * 16)))
        rows, columns = (
            (np.arange(2 * step + 1) + rng.integers(size)) % size,
            (np.arange(2 * step + 1) + rng.integers(size)) % size,
        )
        prints[np.ix_(rows, columns)] = np.maximum(prints[np.ix_(rows, columns)], sole)
    tone = np.clip(
        0.6 * grit + 0.5 * cloud - 0.12 + 0.1 * rake - 0.4 * np.clip(damp * 3 - 1.9, 0, 1) - 0.22 * prints, 0, 1
    )
    relief = grit + 0.25 * rake * (1 - prints) - 0.8 * prints
    return (
        textures.picture(textures.ramp(tone, stops)),
        textures.normals(relief, 4.0),
        textures.surface(np.full((8, 8), 0.95)),
    )


class Materials:
    """Materials of the arena, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        sand = [(0.32, 0.24, 0.17), (0.56, 0.45, 0.33), (0.76, 0.66, 0.52)]
        pale = [(0.46, 0.4, 0.32), (0.68, 0.61, 0.5), (0.84, 0.78, 0.66)]
        clay = [(0.34, 0.16, 0.1), (0.58, 0.3, 0.2), (0.74, 0.48, 0.34)]
        steel = [(0.24, 0.24, 0.25), (0.5, 0.5, 0.5), (0.78, 0.77, 0.75)]
        dark = [(0.12, 0.12, 0.13), (0.24, 0.24, 0.25), (0.38, 0.37, 0.36)]
        oak = [(0.18, 0.11, 0.06), (0.42, 0.28, 0.16), (0.6, 0.44, 0.28)]
        self.sand = self._maps("sand", trodden(1024, 1, sand), 5.0)
        self.lime = self._maps("lime on sand", textures.rough(512, 3, [(0.6, 0.56, 0.48), (0.86, 0.84, 0.78)]), 2.4)
        self.stone = self._maps("stone", textures.stone(512, 5, pale, 4), 2.2)
        self.brick = self._maps("brick", textures.bricks(512, 16, 6, clay, 9), 1.6)
        self.oak = self._maps("oak", textures.wood(512, 13, oak), 1.0)
        self.steel = self._maps("steel", metal.brushed(512, 17, steel), 0.5)
        self.iron = self._maps("iron", metal.brushed(256, 21, dark, 0.3), 0.5)
        self.cloth = self._plain(
            "cloth", textures.picture(np.repeat(0.5 + 0.4 * textures.fractal(128, 25, 0.6)[..., None], 3, 2))
        )
        self.crates = self._plain("crates", lettering.label_sheet(27))
        boards = (
            ("FORGE & FIELD", (160, 40, 30), (240, 228, 200)),
            ("BLUE YARD OIL", (34, 66, 116), (236, 230, 214)),
            ("RING GAZETTE", (232, 222, 196), (36, 32, 30)),
            ("TICK POWDER", (70, 104, 66), (240, 226, 170)),
        )
        self.boards = [self._plain(t, lettering.poster(k, b, f, t)) for k, (t, b, f) in enumerate(boards)]
        self.rules = self._plain("rules", lettering.notice(5, "RING RULES", (236, 228, 206), (90, 26, 24)))
        flags = (((140, 30, 26), (240, 216, 150), "FORGE"), ((28, 58, 104), (236, 230, 214), "YARD"))
        self.flags = [self._plain(w, lettering.banner(30 + k, b, f, w)) for k, (b, f, w) in enumerate(flags)]
        embers = metal.embers(256, 33)
        self.embers = builder.material(Material("embers", *embers, roughness=1.0, emission=(1.0, 0.5, 0.22)), 0.8)
        glow = [self._light(f"glow {k}", c) for k, c in enumerate(((3.0, 0.7, 0.3), (0.4, 1.6, 3.0)))]
        plates = [self._maps(f"coat {k}", metal.riveted(256, 40 + 4 * k, c), 0.5) for k, c in enumerate(COATS)]
        self.coats = [Coat(p, self.iron, self.steel, glow[k % 2]) for k, p in enumerate(plates)]
        self.plates = [self._interface(f[0], interface.plate(*f)) for f in FIGURES]
        self.marks = [
            self._interface(t, interface.mark(t, c)) for t, c in (("!", interface.GOLD), ("?", interface.POWER))
        ]
        self.vitals = self._interface("vitals", interface.vitals())
        self.title = self._interface("title", interface.title())
        self.log = self._interface("log", interface.log())
        self.map = self._interface("map", interface.map_face())
        self.aim = self._interface("aim", interface.aim())
        self.slots = self._interface("slots", interface.slots())
        self.pointer = self._interface("pointer", np.full((8, 8, 3), interface.GOLD, np.uint8))

    def _maps(self, name: str, maps: textures.Maps, tile: float) -> int:
        return self._builder.material(Material(name, *maps, roughness=1.0, metallic=1.0), tile)

    def _plain(self, name: str, albedo: Texture) -> int:
        return self._builder.material(Material(name, albedo, roughness=0.85))

    def _light(self, name: str, emission: tuple[float, float, float]) -> int:
        return self._builder.material(Material(name, base_color=(0.8, 0.8, 0.8), emission=emission))

    def _interface(self, name: str, albedo: Texture) -> int:
        """Add an element of the interface, with holes where the texture has them."""
        look = Material(f"interface {name}", albedo, emission=(SHINE,) * 3, interface=True)
        return self._builder.material(replace(look, alpha="test") if albedo.shape[2] == 4 else look)
