"""Materials of the market: paving, facades, cloth, fruit, plants and everything that carries text. All are rough."""

import numpy as np

from supersampling.scenes.kit import lettering, textures
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.dials import clock_face
from supersampling.scenes.kit.metal import brushed
from supersampling.scenes.kit.textures import Maps, picture, surface
from supersampling.scenes.market import lettering as market_lettering
from supersampling.scenes.market import textures as market_textures
from supersampling.scenes.scene import Material, Texture

SHOPS = (
    ("HALE & DAUGHTER", "BAKERS  -  BREAD  CAKES  ROLLS", (30, 62, 54), (236, 212, 140)),
    ("THE PAPER LANTERN", "BOOKS  MAPS  PRINTS  STATIONERY", (104, 26, 30), (240, 222, 172)),
    ("ORCHARD STORES", "FRUIT  CIDER  PRESERVES", (226, 212, 172), (44, 70, 36)),
    ("I. VOSS, CLOCKS", "REPAIRS WHILE YOU WAIT", (24, 34, 64), (232, 206, 128)),
    ("CAFE AM BRUNNEN", "COFFEE  CHOCOLATE  LEMONADE", (214, 178, 92), (64, 28, 20)),
    ("LINDEN APOTHECARY", "HERBS  SALVES  SPICES", (42, 84, 92), (240, 234, 212)),
)
WORDS = ("BREAD", "BOOKS", "CIDER", "CLOCKS")
BILLS = (
    ("AUTUMN FAIR", (232, 220, 190), (150, 30, 30)),
    ("BRASS BAND", (24, 46, 80), (240, 226, 180)),
    ("MAP & MOON", (226, 190, 70), (24, 24, 30)),
    ("THE REGATTA", (40, 84, 60), (236, 232, 214)),
    ("PUPPET PLAY", (190, 84, 40), (244, 232, 200)),
)
CLOTHS = (
    ((0.93, 0.9, 0.82), (0.72, 0.16, 0.13)),
    ((0.93, 0.9, 0.82), (0.1, 0.36, 0.42)),
    ((0.95, 0.88, 0.7), (0.82, 0.5, 0.1)),
)
PENNANTS = ((0.78, 0.2, 0.16), (0.92, 0.84, 0.66), (0.14, 0.38, 0.46), (0.88, 0.62, 0.16))

_RED = [(0.34, 0.14, 0.09), (0.6, 0.3, 0.2), (0.74, 0.45, 0.32)]
_STONE = [(0.42, 0.37, 0.3), (0.66, 0.6, 0.5), (0.82, 0.76, 0.66)]
_TILES = [(0.36, 0.16, 0.1), (0.66, 0.34, 0.21), (0.76, 0.47, 0.31)]
_OAK = [(0.2, 0.12, 0.07), (0.46, 0.31, 0.18), (0.62, 0.46, 0.29)]
_GREY = [(0.4, 0.38, 0.35), (0.66, 0.63, 0.58), (0.82, 0.79, 0.72)]
_IRON = [(0.07, 0.08, 0.08), (0.16, 0.17, 0.17), (0.26, 0.27, 0.26)]
_LEAF = [(0.1, 0.2, 0.04), (0.34, 0.44, 0.1), (0.68, 0.66, 0.22)]
_IVY = [(0.06, 0.15, 0.05), (0.2, 0.36, 0.12), (0.5, 0.52, 0.22)]
_BLOOM = [(0.12, 0.26, 0.08), (0.3, 0.42, 0.16), (0.86, 0.2, 0.24)]
_APPLE = ((0.42, 0.52, 0.12), (0.78, 0.7, 0.2), (0.8, 0.16, 0.12))
_ORANGE = ((0.7, 0.32, 0.06), (0.9, 0.52, 0.1), (0.95, 0.68, 0.2))
_PLUM = ((0.15, 0.1, 0.17), (0.3, 0.17, 0.25), (0.48, 0.36, 0.46))


def _roman(text: str, seed: int) -> Maps:
    """Draw a stone band, eight times as wide as high, with its text cut in."""
    albedo, height = lettering.inscription(text, 1024, 128, 44, seed)
    # Darker than new stone: letters have to be read in full sun.
    return picture((albedo / 255) ** 1.6), textures.normals(height, 5.0), surface(np.full((8, 8), 0.85))


def _pennant_sheet(size: int = 128) -> Texture:
    """Draw four colours of bunting side by side, woven."""
    y, x = np.mgrid[:size, : 4 * size]
    color = np.asarray(PENNANTS)[x // size]
    return picture(color * (0.8 + 0.2 * ((x // 2 + y // 2) % 2))[..., None])


class Palette:
    """Materials of the market, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        self._ground()
        self._print()
        self._cloth()
        self._green()

    def _ground(self) -> None:
        """Add masonry, wood, iron."""
        self.fans = self._maps("fan cobbles", market_textures.fan_cobbles(768, 1), 2.6)
        self.setts = self._maps("setts", textures.cobbles(512, 2), 1.5)
        self.brick = self._maps("brick", textures.bricks(512, 14, 5, _RED, 3), 1.2)
        self.plaster = self._maps("plaster", market_textures.plaster(512, 4), 2.4)
        self.stone = self._maps("dressed stone", textures.stone(512, 5, _STONE, 4), 1.6)
        self.roof = self._maps("roof tiles", textures.bricks(256, 9, 6, _TILES, 7), 1.5)
        self.wood = self._maps("planks", textures.wood(512, 8, _OAK), 1.0)
        self.paint = self._maps("painted wood", textures.wood(256, 9, _GREY, 3), 0.6)
        self.iron = self._maps("iron", brushed(256, 10, _IRON, 0.0), 0.5)
        self.shutter = self._maps("shutters", market_textures.louvres(256, 11), 1.0)
        self.earth = self._maps("earth", textures.rough(256, 12, [(0.1, 0.07, 0.05), (0.4, 0.31, 0.22)]), 0.7)
        self.bark = self._maps("bark", textures.rough(256, 13, [(0.14, 0.11, 0.08), (0.5, 0.42, 0.33)]), 0.4)
        self.window = self._flat("curtained panes", market_textures.panes(256, 14))

    def _print(self) -> None:
        """Add everything that can be read."""
        self.papers = [self._flat(f"newspaper {k}", lettering.newspaper(k), 0.7) for k in (0, 2)]
        self.bills = [self._flat(f"bill {k}", market_lettering.bill(k, *bill), 0.8) for k, bill in enumerate(BILLS)]
        self.notice = self._flat("by-laws", lettering.notice(5, "MARKET RULES", (236, 230, 212), (30, 40, 70)), 0.75)
        self.spines = self._flat("book spines", lettering.spines(3))
        self.covers = self._flat("book covers", market_lettering.covers(4))
        self.crates = self._flat("crate labels", lettering.label_sheet(6))
        self.tags = self._flat("price tags", market_lettering.price_tags(7))
        heads = ("TODAY", "LUNCH 12 - 3", "FRUIT & NUTS")
        self.slates = [self._flat(f"slate {k}", market_lettering.slate(20 + k, h)) for k, h in enumerate(heads)]
        self.boards = [self._flat(f"shop {k}", market_lettering.fascia(k, *s)) for k, s in enumerate(SHOPS)]
        looks = (((52, 30, 22), (236, 206, 130)), ((28, 54, 70), (236, 226, 196)))
        self.signs = [
            self._flat(f"sign {k}", market_lettering.hanging_sign(k, w, *looks[k % 2])) for k, w in enumerate(WORDS)
        ]
        self.frieze = self._maps("frieze", _roman("MERCATUS  .  TOWN HALL AND CORN EXCHANGE  .  ANNO 1687", 30), 1.0)
        self.plinth = self._maps("plinth", _roman("TO THE BUILDERS OF THE BRIDGE", 31), 1.0)
        self.clock = self._flat("clock", clock_face(512), 0.7)

    def _cloth(self) -> None:
        """Add canvas, sacking, banners and bunting, seen from both sides."""
        self.awnings = [self._cut(f"canvas {k}", market_textures.awning(256, 40 + k, c)) for k, c in enumerate(CLOTHS)]
        sack, weave = market_lettering.sacking(45)
        self.sack = self._maps("sacking", (sack, textures.normals(weave, 1.5), surface(np.full((8, 8), 0.9))), 1.0)
        looks = (((130, 28, 34), (240, 214, 140)), ((26, 54, 96), (236, 228, 206)))
        self.banners = [
            self._cut(f"banner {w}", lettering.banner(50 + k, *looks[k], w)) for k, w in enumerate(("MARKET", "BRIDGE"))
        ]
        self.bunting = self._cut("bunting", _pennant_sheet())

    def _green(self) -> None:
        """Add leaves (alpha-tested) and fruit."""
        self.leaves = self._cut("linden leaves", textures.foliage(512, 60, 64, _LEAF))
        self.ivy = self._cut("ivy", textures.foliage(512, 61, 80, _IVY))
        self.flowers = self._cut("geraniums", textures.foliage(256, 62, 60, _BLOOM))
        kinds = (_APPLE, _ORANGE, _PLUM)
        self.fruit = [
            self._maps(f"fruit {k}", market_textures.fruit(256, 63 + k, 330, s), 1.0) for k, s in enumerate(kinds)
        ]

    def _maps(self, name: str, maps: Maps, tile: float) -> int:
        """Add a dielectric material with its roughness raised: nothing on the market shines."""
        albedo, normal, rough = maps
        matte = np.maximum(rough[::2, ::2], np.array((160, 0, 255), np.uint8)) * np.array((1, 0, 1), np.uint8)
        return self._builder.material(Material(name, albedo, normal, matte, roughness=1.0, metallic=0.0), tile)

    def _flat(self, name: str, albedo: Texture, bright: float = 1.0) -> int:
        return self._builder.material(Material(name, albedo, base_color=(bright, bright, bright), roughness=0.85))

    def _cut(self, name: str, albedo: Texture) -> int:
        """Add a thin material: leaves with holes between them, or cloth."""
        tested = albedo.shape[2] == 4
        return self._builder.material(
            Material(name, albedo, roughness=0.9, alpha="test" if tested else "opaque", double_sided=True)
        )
