"""Materials of the louvred street; all are matt."""

from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.textures import Maps
from supersampling.scenes.louvres import textures as tex
from supersampling.scenes.scene import Material, Texture

CREAM, NAVY, RED, OCHRE, GREEN = (
    (0.93, 0.89, 0.8),
    (0.1, 0.17, 0.32),
    (0.72, 0.16, 0.13),
    (0.88, 0.62, 0.2),
    (0.18, 0.4, 0.3),
)


class Palette:
    """Materials of the louvred street, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        cedar = [(0.33, 0.19, 0.12), (0.52, 0.33, 0.22), (0.66, 0.46, 0.32)]
        ash = [(0.52, 0.45, 0.36), (0.72, 0.64, 0.53), (0.84, 0.77, 0.66)]
        self.cedar = self._maps("cedar", tex.timber(512, 1, cedar), 0.8)
        self.ash = self._maps("ash", tex.timber(512, 2, ash), 0.8)
        self.white = self._maps("white paint", tex.paint(256, 3, (0.93, 0.92, 0.89)), 1.0)
        self.dark = self._maps("anthracite paint", tex.paint(256, 4, (0.24, 0.26, 0.29)), 1.0)
        self.sage = self._maps("sage paint", tex.paint(256, 5, (0.55, 0.66, 0.55)), 1.0)
        self.rust = self._maps("terracotta paint", tex.paint(256, 6, (0.76, 0.4, 0.27)), 1.0)
        self.mustard = self._maps("mustard paint", tex.paint(256, 7, (0.88, 0.68, 0.26)), 1.0)
        self.blue = self._maps("blue paint", tex.paint(256, 8, (0.3, 0.45, 0.62)), 1.0)
        self.pale = self._maps(
            "pale plaster", tex.plaster(512, 9, [(0.66, 0.62, 0.55), (0.85, 0.81, 0.73), (0.93, 0.9, 0.84)]), 2.5
        )
        self.clay = self._maps(
            "clay plaster", tex.plaster(512, 10, [(0.5, 0.26, 0.18), (0.72, 0.42, 0.3), (0.82, 0.56, 0.42)]), 2.5
        )
        self.shade = self._maps(
            "dark room", tex.plaster(256, 11, [(0.1, 0.11, 0.13), (0.17, 0.18, 0.2), (0.24, 0.25, 0.27)]), 2.0
        )
        self.paving = self._maps(
            "pavers", tex.pavers(1024, 20, 10, [(0.42, 0.4, 0.38), (0.6, 0.57, 0.53), (0.72, 0.69, 0.64)], 12), 2.0
        )
        self.band = self._maps(
            "dark pavers", tex.pavers(512, 12, 6, [(0.2, 0.2, 0.21), (0.32, 0.31, 0.31), (0.42, 0.4, 0.39)], 13), 1.2
        )
        self.mosaic = self._maps("mosaic", tex.mosaic(512, 16, [(0.86, 0.84, 0.78), (0.16, 0.36, 0.44)], 14), 0.72)
        self.chess = self._maps("red mosaic", tex.mosaic(512, 16, [(0.9, 0.86, 0.78), (0.62, 0.22, 0.16)], 15), 0.72)
        self.hedge = self._maps("hedge", tex.hedge(512, 16), 1.0)
        cloths = (
            ("awning red", tex.stripes(512, 4, (RED, CREAM), 20), 0.28),
            ("awning green", tex.stripes(512, 4, (GREEN, CREAM), 21), 0.26),
            ("awning navy", tex.stripes(512, 4, (NAVY, CREAM), 22), 0.24),
        )
        self.awnings = tuple(self._cloth(*cloth) for cloth in cloths)
        self.deck = (
            self._cloth("deck blue", tex.stripes(512, 6, (NAVY, CREAM), 23), 0.3),
            self._cloth("deck ochre", tex.stripes(512, 6, (OCHRE, CREAM), 24), 0.3),
        )
        self.pinstripe = self._cloth("pinstripe", tex.stripes(512, 12, (CREAM, NAVY), 25, 0.22), 0.5)
        self.ticking = self._cloth("ticking", tex.stripes(512, 10, (NAVY, CREAM), 26, 0.3), 0.4)
        self.gingham = self._cloth("gingham red", tex.gingham(512, 8, (RED, CREAM), 27), 0.28)
        self.check = self._cloth("gingham blue", tex.gingham(512, 8, (NAVY, CREAM), 28), 0.28)

    def _maps(self, name: str, maps: Maps, tile: float) -> int:
        albedo, normal, surface = maps
        return self._builder.material(Material(name, albedo, normal, surface, roughness=1.0), tile)

    def _cloth(self, name: str, albedo: Texture, tile: float) -> int:
        return self._builder.material(Material(name, albedo, roughness=0.9, double_sided=True), tile)
