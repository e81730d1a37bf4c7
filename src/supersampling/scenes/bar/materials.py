"""Materials of the bar."""

from supersampling.scenes.bar import textures as tex
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.textures import Maps
from supersampling.scenes.scene import Material, Texture

Color = tuple[float, float, float]
NEON: dict[str, Color] = {"pink": (3.0, 0.12, 0.75), "cyan": (0.08, 1.9, 2.7), "amber": (3.2, 0.95, 0.08)}


class Palette:
    """Materials of the bar, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        self._patterned()
        self._lacquers()
        self._glowing()

    def _patterned(self) -> None:
        """Add stone, tiles, wood, metal, leather and wall covering."""
        brass = [(0.62, 0.44, 0.16), (0.87, 0.68, 0.34), (0.97, 0.84, 0.55)]
        steel = [(0.62, 0.62, 0.64), (0.82, 0.82, 0.83), (0.93, 0.93, 0.92)]
        copper = [(0.6, 0.3, 0.18), (0.86, 0.5, 0.33), (0.96, 0.68, 0.5)]
        mahogany = [(0.09, 0.04, 0.03), (0.22, 0.1, 0.065), (0.36, 0.19, 0.12)]
        ebony = [(0.13, 0.08, 0.06), (0.28, 0.18, 0.13), (0.42, 0.29, 0.21)]
        self.floor = self._maps("polished marble", tex.checkers(1024, 4, 1), 3.2)
        self.tiles = self._maps(
            "green tiles", tex.glazed(512, 12, 6, [(0.03, 0.2, 0.16), (0.07, 0.42, 0.32), (0.3, 0.62, 0.46)], 11), 1.2
        )
        self.dark_tiles = self._maps(
            "blue tiles", tex.glazed(512, 6, 6, [(0.05, 0.08, 0.22), (0.1, 0.2, 0.42), (0.22, 0.36, 0.58)], 21), 0.9
        )
        self.top = self._maps("mahogany lacquer", tex.veneer(512, 31, mahogany), 1.2)
        self.wood = self._maps("ebony lacquer", tex.veneer(512, 41, ebony), 1.0)
        self.brass = self._maps("brass", tex.polished(256, 51, brass), 0.4)
        self.chrome = self._maps("chrome", tex.polished(256, 61, steel, 0.1), 0.4)
        self.copper = self._maps("copper", tex.polished(256, 71, copper, 0.16), 0.4)
        self.red = self._maps(
            "red leather", tex.tufted(512, 81, [(0.16, 0.02, 0.025), (0.38, 0.05, 0.055), (0.54, 0.12, 0.1)]), 0.8
        )
        self.teal = self._maps(
            "teal leather", tex.tufted(512, 91, [(0.02, 0.15, 0.18), (0.05, 0.34, 0.36), (0.2, 0.5, 0.48)]), 0.7
        )
        self.ceiling = self._maps("pressed tin", tex.pressed_tin(512, 101), 1.6)
        self.paper = self._maps(
            "fan wall covering", tex.fans(512, 111, [(0.09, 0.05, 0.15), (0.2, 0.1, 0.27), (0.34, 0.2, 0.38)]), 0.8
        )
        self.labels = self._builder.material(Material("labels", tex.labels(5), roughness=0.35))

    def _lacquers(self) -> None:
        """Add lacquer and bottle glass, which shines through a little."""
        self.black = self._plain("black lacquer", (0.022, 0.02, 0.024), 0.1)
        self.cream = self._plain("cream lacquer", (0.66, 0.58, 0.44), 0.16)
        self.ruby = self._plain("ruby lacquer", (0.36, 0.02, 0.03), 0.12)
        self.dark_glass = self._plain("smoked glass", (0.03, 0.034, 0.04), 0.08)
        tints: tuple[Color, ...] = (
            (0.02, 0.05, 0.022),
            (0.09, 0.028, 0.02),
            (0.06, 0.02, 0.02),
            (0.02, 0.02, 0.07),
            (0.12, 0.14, 0.145),
        )
        self.glass = tuple(
            self._plain(f"bottle glass {k}", t, 0.09, (0.4 * t[0], 0.4 * t[1], 0.4 * t[2])) for k, t in enumerate(tints)
        )

    def _glowing(self) -> None:
        """Add the window, lit onyx and signs, neon, lamps."""
        self.onyx = self._maps("onyx", tex.onyx(512, 121), 1.8, (1.1, 0.95, 0.8))
        self.town = self._builder.material(
            Material("window", tex.night_town(1024, 288, 6), roughness=0.12, emission=(1.1, 1.1, 1.25))
        )
        self.signs = tuple(
            self._sign(*words)
            for words in (
                ("THE LAST RAY", "cocktails & mirrors", (40, 8, 16), (255, 120, 90)),
                ("OPEN LATE", "until the lamps go out", (8, 22, 40), (120, 220, 255)),
                ("ON TAP", "pale - amber - porter - stout", (34, 22, 6), (255, 200, 100)),
                ("LIVE PIANO", "every night at ten", (30, 8, 40), (240, 150, 255)),
            )
        )
        self.neon = {name: self._plain(f"{name} neon", (0.8, 0.8, 0.8), 0.15, glow) for name, glow in NEON.items()}
        self.bulb = self._plain("bulb", (0.9, 0.85, 0.7), 0.2, (9.0, 6.2, 3.2))
        self.opal = self._plain("opal globe", (0.85, 0.8, 0.72), 0.15, (2.6, 2.1, 1.5))
        self.candle = self._plain("candle glass", (0.7, 0.3, 0.1), 0.12, (2.6, 1.1, 0.25))
        self.strip = self._plain("shelf light", (0.9, 0.8, 0.6), 0.2, (4.0, 2.9, 1.6))

    def _maps(self, name: str, maps: Maps, tile: float, emission: Color = (0.0, 0.0, 0.0)) -> int:
        albedo, normal, surface = maps
        material = Material(name, albedo, normal, surface, roughness=1.0, metallic=1.0, emission=emission)
        return self._builder.material(material, tile)

    def _plain(self, name: str, color: Color, roughness: float, emission: Color = (0.0, 0.0, 0.0)) -> int:
        return self._builder.material(Material(name, base_color=color, roughness=roughness, emission=emission))

    def _sign(self, text: str, small: str, back: tuple[int, int, int], front: tuple[int, int, int]) -> int:
        maps: tuple[Texture, Texture] = tex.lit_sign(text, small, back, front)
        return self._builder.material(
            Material(text, maps[0], None, maps[1], roughness=1.0, metallic=1.0, emission=(3.0, 3.0, 3.0))
        )
