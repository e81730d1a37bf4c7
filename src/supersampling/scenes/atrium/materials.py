"""Materials of the atrium: masonry, wood, metal, plants and everything that carries text."""

from typing import TypedDict, Unpack

import numpy as np

from supersampling.scenes.atrium.parts import FLUTES, GIRTH
from supersampling.scenes.kit import lettering, metal, textures
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.dials import clock_face
from supersampling.scenes.scene import Material, Texture

FRIEZES = ("LIGHT IS SAMPLED AND THE FRAME REMEMBERS", "WHAT THE EDGE HIDES THE MOTION SHOWS AGAIN")
PAVINGS = ("STEP BY STEP THE GRID RESOLVES", "MIND THE ALIAS - FOLLOW THE LINE")
BANNERS = ("FILTER", "VECTOR", "RASTER", "JITTER")
POSTERS = (
    ("MOIRE 1971", (232, 220, 190), (150, 30, 30)),
    ("LENS FAIR", (24, 46, 80), (240, 226, 180)),
    ("EDGE & LINE", (226, 190, 70), (24, 24, 30)),
    ("NYQUIST", (40, 84, 60), (236, 232, 214)),
)


class Look(TypedDict, total=False):
    """Fields of a `Material` that are not textures."""

    roughness: float
    metallic: float
    emission: tuple[float, float, float]


def _inscribed_band(text: str, seed: int) -> textures.Maps:
    """Draw a stone band, eight times as wide as high, with its text cut in."""
    albedo, height = lettering.inscription(text, 1024, 128, 36, seed)
    return albedo, textures.normals(height, 5.0), textures.surface(np.full((8, 8), 0.8))


def _groove(albedo: Texture, count: int) -> Texture:
    """Darken ``count`` upright grooves, into which the light of the sky does not reach."""
    across = np.arange(albedo.shape[1]) / albedo.shape[1] * count
    return textures.picture(albedo / 255 * (1 - 0.45 * (0.5 - 0.5 * np.cos(2 * np.pi * across)) ** 2)[:, None])


class Palette:
    """Materials of the atrium, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        red = [(0.3, 0.12, 0.08), (0.58, 0.27, 0.18), (0.72, 0.42, 0.29)]
        pale = [(0.5, 0.44, 0.35), (0.74, 0.67, 0.55), (0.88, 0.82, 0.7)]
        ochre = [(0.42, 0.33, 0.22), (0.66, 0.53, 0.36), (0.8, 0.69, 0.5)]
        oak = [(0.16, 0.09, 0.05), (0.4, 0.25, 0.13), (0.58, 0.4, 0.23)]
        marble = ([(0.36, 0.33, 0.29), (0.66, 0.62, 0.54)], [(0.14, 0.1, 0.1), (0.4, 0.2, 0.15)])
        brass = [(0.36, 0.26, 0.1), (0.7, 0.54, 0.25), (0.9, 0.76, 0.45)]
        self.brick = self._maps("brick", textures.bricks(1024, 24, 8, red, 1), 2.0)
        column = textures.stone(512, 2, pale, 2)
        self.column = self._maps("column stone", column, 1.3)
        self.shaft = self._maps("fluted stone", (_groove(column[0], FLUTES), *column[1:]), GIRTH)
        self.clay = self._maps("clay", textures.rough(512, 17, [(0.38, 0.16, 0.1), (0.8, 0.47, 0.32)]), 0.5)
        self.ashlar = self._maps("ashlar", textures.stone(512, 3, ochre, 4), 2.0)
        self.tiles = self._maps("tiles", textures.floor_tiles(768, 6, marble, 4), 3.0)
        self.cobbles = self._maps("cobbles", textures.cobbles(512, 5), 1.6)
        self.oak = self._maps("oak", textures.wood(512, 6, oak), 1.0)
        self.roof = self._maps(
            "roof tiles", textures.bricks(512, 14, 10, [(0.4, 0.17, 0.1), (0.75, 0.4, 0.25)], 7), 2.0
        )
        self.soil = self._maps("soil", textures.rough(512, 8, [(0.1, 0.07, 0.05), (0.45, 0.34, 0.24)]), 0.7)
        iron = [(0.07, 0.07, 0.08), (0.2, 0.2, 0.21), (0.34, 0.33, 0.32)]
        self.iron = self._maps("iron", metal.brushed(256, 9, iron, 0.4), 0.5)
        self.brass = self._maps("brass", metal.brushed(512, 10, brass, 0.55), 0.8)
        self.cart = self._maps("painted cart", metal.riveted(512, 11, [(0.08, 0.2, 0.22), (0.2, 0.45, 0.45)]), 0.8)
        self.papers = [self._flat(f"newspaper {k}", lettering.newspaper(k)) for k in range(4)]
        self.posters = [self._flat(f"poster {k}", lettering.poster(k, b, f, t)) for k, (t, b, f) in enumerate(POSTERS)]
        self.notice = self._flat("library rules", lettering.notice(5, "LIBRARY RULES", (236, 230, 212), (30, 40, 70)))
        self.spines = self._flat("book spines", lettering.spines(3), roughness=0.6)
        self.crates = self._flat("crate labels", lettering.label_sheet(6))
        self.friezes = [self._maps(f"frieze {k}", _inscribed_band(t, 30 + k), 1.0) for k, t in enumerate(FRIEZES)]
        self.pavings = [self._maps(f"paving {k}", _inscribed_band(t, 40 + k), 1.0) for k, t in enumerate(PAVINGS)]
        cloth = [
            ((130, 28, 34), (240, 214, 140)),
            ((26, 54, 96), (236, 228, 206)),
            ((222, 200, 140), (70, 24, 30)),
            ((34, 82, 62), (238, 214, 150)),
        ]
        self.banners = [
            self._flat(f"banner {k}", lettering.banner(20 + k, *cloth[k], word)) for k, word in enumerate(BANNERS)
        ]
        self.clock = self._flat("clock", clock_face())
        leaves = [(0.05, 0.12, 0.03), (0.2, 0.42, 0.1), (0.5, 0.66, 0.24)]
        fern = [(0.08, 0.12, 0.02), (0.42, 0.44, 0.12), (0.72, 0.68, 0.28)]
        self.leaves = [
            self._cut("leaves", textures.foliage(512, 12, 90, leaves)),
            self._cut("fern", textures.foliage(512, 13, 80, fern)),
        ]
        self.lattice = self._cut("lattice", textures.lattice(512, 8, 0.32, (0.5, 0.34, 0.2), 14, True))
        self.mesh = self._cut("wire mesh", textures.lattice(512, 12, 0.22, (0.3, 0.3, 0.32), 15))
        self.glow = self._flat("lantern glass", metal.embers(256, 16)[0], emission=(5.0, 3.6, 2.0))

    def _maps(self, name: str, maps: textures.Maps, tile: float) -> int:
        material = Material(name, *maps, roughness=1.0, metallic=1.0)
        return self._builder.material(material, tile)

    def _flat(self, name: str, albedo: Texture, **look: Unpack[Look]) -> int:
        return self._builder.material(Material(name, albedo, **look))

    def _cut(self, name: str, albedo: Texture) -> int:
        return self._builder.material(Material(name, albedo, alpha="test", double_sided=True))
