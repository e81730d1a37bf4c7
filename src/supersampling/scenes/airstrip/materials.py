"""Materials of the airstrip. Everything is matt: roughness 0.8 and more, no metal."""

import numpy as np
from PIL import Image, ImageDraw

from supersampling.scenes.airstrip.textures import blades, crown, patchy, runway, striped, worn
from supersampling.scenes.kit import lettering, metal, textures
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.lettering import Rgb
from supersampling.scenes.scene import Material, Texture

LIVERIES: tuple[tuple[Rgb, Rgb, Rgb, str], ...] = (
    ((206, 44, 32), (244, 236, 214), (26, 26, 32), "7"),
    ((238, 186, 40), (28, 40, 72), (240, 234, 216), "23"),
    ((40, 92, 160), (236, 232, 220), (222, 74, 38), "41"),
    ((56, 128, 84), (242, 226, 160), (30, 34, 30), "16"),
)
MURALS: tuple[tuple[Rgb, Rgb, Rgb, str, str], ...] = (
    ((38, 66, 104), (226, 196, 128), (204, 72, 48), "HALCYON AIR", "LESSONS  CHARTERS  REPAIRS  SINCE 1931"),
    ((172, 58, 42), (238, 222, 188), (40, 44, 58), "PYLON RACES", "EIGHT LAPS  ONE LINE  NO SECOND LOOK"),
    ((58, 104, 84), (236, 216, 164), (214, 130, 44), "PROP SHOP", "BLADES CARVED AND BALANCED TO A GRAM"),
)


def livery(seed: int, base: Rgb, second: Rgb, third: Rgb, number: str) -> Texture:
    """Draw the paint of a plane, 1024 x 1024: right and left side (a quarter each), wing from above (lower half)."""
    image = Image.new("RGB", (1024, 1024), base)
    draw = ImageDraw.Draw(image)
    for top, flip in ((0, False), (256, True)):
        side = Image.new("RGB", (1024, 256), base)
        pen = ImageDraw.Draw(side)
        pen.polygon([(0, 120), (1024, 60), (1024, 120), (0, 150)], second)
        pen.polygon([(0, 156), (1024, 128), (1024, 148), (0, 166)], third)
        for k in range(8):
            for row in range(6):
                if (k + row) % 2:
                    pen.rectangle((800 + 14 * k, 20 + 40 * row, 813 + 14 * k, 59 + 40 * row), third)
        pen.rectangle((924, 0, 1024, 256), second)
        side = side.transpose(Image.Transpose.FLIP_LEFT_RIGHT) if flip else side
        pen, middle = ImageDraw.Draw(side), 620 if flip else 404
        pen.ellipse((middle - 82, 22, middle + 82, 186), second, third, 8)
        pen.text((middle, 104), number, third, lettering.font(112, "DejaVuSans-Bold"), anchor="mm")
        pen.text(
            (middle + (200 if flip else -200), 96),
            f"N-{number}RX",
            third,
            lettering.font(44, "DejaVuSans-Bold"),
            anchor="mm",
        )
        pen.text((middle, 216), "NO STEP  FUEL 60 L  AVGAS 100", second, lettering.font(20), anchor="mm")
        image.paste(side, (0, top))
    draw.rectangle((0, 512, 1024, 560), second)
    for k in range(16):
        for row in range(16):
            if (k + row) % 2:
                for left in (0, 1024 - 128):
                    box = (left + 8 * k, 512 + 32 * row, left + 8 * k + 7, 543 + 32 * row)
                    draw.rectangle(box, third if left else second)
    for x in (150, 330, 512, 694, 874):
        draw.line((x, 512, x, 1024), third, 3)
    for y in (620, 900):
        draw.line((0, y, 1024, y), third, 2)
    for x in (250, 780):
        draw.text((x, 790), number, second, lettering.font(210, "DejaVuSans-Bold"), anchor="mm")
    draw.text((512, 660), "HALCYON RACE TEAM", second, lettering.font(26, "DejaVuSans-Bold"), anchor="mm")
    return worn(np.asarray(image), seed, 0.22)


def mural(seed: int, back: Rgb, light: Rgb, accent: Rgb, name: str, line: str) -> Texture:
    """Draw a hangar front 1024 x 512: rays, a large name, lines of type, door leaves and ribs."""
    y, x = np.mgrid[:512, :1024]
    angle = np.arctan2(520 - y, x - 512)
    rays = (np.floor(angle / np.pi * 34) % 2)[..., None] > 0.5
    sky = np.where(rays, back, np.clip(np.array(back) * 1.35 + 18, 0, 255)).astype(np.uint8)
    image = Image.fromarray(sky)
    draw = ImageDraw.Draw(image)
    draw.pieslice((362, 350, 662, 650), 180, 360, accent, light, 6)
    for k in range(64):
        draw.rectangle((16 * k, 470, 16 * k + 15, 490), light if k % 2 else accent)
        draw.rectangle((16 * k, 491, 16 * k + 15, 511), accent if k % 2 else light)
    letters = lettering.font(112, "DejaVuSans-Bold")
    draw.text((512, 190), name, light, letters, anchor="mm", stroke_width=5, stroke_fill=accent)
    draw.text((512, 272), line, light, lettering.font(34, "DejaVuSans-Bold"), anchor="mm")
    for k in range(2):
        draw.text(
            (190 + 644 * k, 400),
            f"DOOR {2 * k + 1}\nKEEP CLEAR",
            light,
            lettering.font(30),
            anchor="mm",
            align="center",
        )
    for left in range(0, 1024, 128):
        draw.line((left, 120, left, 512), (24, 22, 22), 4)
    painted = worn(np.asarray(image), seed, 0.3)
    rib = 0.82 + 0.18 * np.sin(2 * np.pi * x / 8)
    return textures.picture(painted / 255 * rib[..., None])


def container_sides(seed: int) -> Texture:
    """Draw an atlas 1024 x 1024 of eight container sides, two across and four down."""
    image = Image.new("RGB", (1024, 1024))
    colors = (
        (164, 62, 40),
        (44, 90, 130),
        (196, 150, 44),
        (70, 110, 80),
        (150, 150, 146),
        (196, 92, 36),
        (64, 70, 96),
        (120, 44, 56),
    )
    names = ("RASTER LINE", "NORDKAI", "BLUE GULL", "HALCYON", "TRANSFORM", "PICA", "ATLAS", "MERIDIAN")
    rng = np.random.default_rng(seed)
    for k in range(8):
        side = Image.new("RGB", (512, 256), colors[k])
        draw = ImageDraw.Draw(side)
        for x in range(0, 512, 16):
            draw.rectangle((x, 0, x + 5, 256), tuple(int(0.7 * c) for c in colors[k]))
        draw.rectangle((0, 0, 511, 255), outline=tuple(int(0.5 * c) for c in colors[k]), width=12)
        draw.text((256, 110), names[k], (238, 232, 216), lettering.font(64, "DejaVuSans-Bold"), anchor="mm")
        code = f"RSTU {rng.integers(100000, 999999)} {k}"
        draw.text((490, 34), code, (238, 232, 216), lettering.font(24, "DejaVuSansMono"), anchor="rm")
        draw.text((28, 216), "MAX GROSS 30480 KG  TARE 2230 KG", (238, 232, 216), lettering.font(18), anchor="lm")
        image.paste(side, (512 * (k % 2), 256 * (k // 2)))
    return worn(np.asarray(image), seed, 0.35)


class Paints:
    """Materials of the airstrip, added to a builder; one material index per name."""

    def __init__(self, builder: Builder) -> None:
        self._builder = builder
        clay = [(0.34, 0.16, 0.11), (0.58, 0.3, 0.2), (0.74, 0.46, 0.33)]
        pale = [(0.34, 0.42, 0.44), (0.5, 0.58, 0.58), (0.68, 0.74, 0.72)]
        grass = [(0.14, 0.17, 0.07), (0.34, 0.37, 0.16), (0.6, 0.56, 0.32)]
        dark = [(0.16, 0.16, 0.17), (0.3, 0.3, 0.3), (0.46, 0.45, 0.43)]
        planks = [(0.3, 0.2, 0.12), (0.54, 0.4, 0.26), (0.72, 0.58, 0.4)]
        self.brick = self._matt("brick", textures.bricks(512, 16, 6, clay, 1), 1.5)
        self.roof = self._matt("roof sheet", metal.corrugated(512, 6, pale), 2.0)
        self.grass = self._matt("grass", patchy(textures.rough(512, 9, grass, "grass")), 3.2)
        self.tarmac = self._matt("runway slabs", runway(1024, 12), 7.0)
        self.slabs = self._matt("slabs", metal.concrete(512, 15), 3.0)
        teal, rust = (
            [(0.1, 0.3, 0.32), (0.2, 0.46, 0.46), (0.4, 0.62, 0.6)],
            [(0.4, 0.14, 0.08), (0.66, 0.26, 0.14), (0.8, 0.44, 0.3)],
        )
        self.lorries = [
            self._matt(f"lorry {k}", metal.riveted(256, 20 + k, paint), 1.1) for k, paint in enumerate((rust, teal))
        ]
        self.iron = self._matt("dark iron", metal.brushed(256, 24, dark, 0.0), 0.5)
        self.wood = self._matt("planks", textures.wood(512, 28, planks), 1.2)
        self.glass = self._flat("dull glass", striped(64, (54, 66, 76), (62, 75, 86), 4), 0.9)
        self.crates = self._flat("crates", lettering.label_sheet(31))
        self.cone = self._flat("pylon", striped(128, (216, 76, 32), (236, 230, 214), 6))
        self.white = self._flat("line paint", striped(128, (214, 208, 190), (196, 190, 172), 4), 0.5)
        self.containers = self._flat("containers", container_sides(33))
        self.murals = [self._flat(f"mural {k}", mural(40 + 5 * k, *m)) for k, m in enumerate(MURALS)]
        self.liveries = [self._flat(f"livery {k}", livery(60 + 5 * k, *c)) for k, c in enumerate(LIVERIES)]
        boards = (
            ("FRAME FUEL", (236, 200, 60), (30, 34, 60)),
            ("VECTOR OIL", (240, 236, 224), (170, 40, 32)),
            ("NYQUIST TYRES", (34, 60, 50), (240, 228, 180)),
            ("AIR MAIL", (46, 74, 120), (238, 226, 190)),
        )
        self.boards = [self._flat(t, lettering.poster(k, b, f, t)) for k, (t, b, f) in enumerate(boards)]
        self.notices = [
            self._flat("race rules", lettering.notice(3, "RACE RULES", (236, 230, 212), (30, 40, 70))),
            self._flat("start list", lettering.notice(4, "START LIST", (206, 220, 206), (18, 50, 30))),
        ]
        self.tank = self._flat("tank", container_sides(35), cell=True)
        self.fence = self._cut("wire mesh", textures.lattice(256, 8, 0.18, (0.5, 0.52, 0.52), 70, True), 0.5)
        self.tufts = self._cut("tufts", blades(256, 72), 1.0)
        self.leaves = self._cut("leaves", crown(512, 74), 1.0)

    def _matt(self, name: str, maps: textures.Maps, tile: float) -> int:
        albedo, normal, surface = maps
        rough = textures.surface(0.8 + 0.2 * surface[..., 0] / 255.0)
        return self._builder.material(Material(name, albedo, normal, rough, roughness=1.0), tile)

    def _flat(self, name: str, albedo: Texture, tile: float = 1.0, cell: bool = False) -> int:
        picture = albedo[256:512, :512] if cell else albedo
        return self._builder.material(Material(name, picture, roughness=0.85), tile)

    def _cut(self, name: str, albedo: Texture, tile: float) -> int:
        return self._builder.material(
            Material(name, albedo, roughness=0.9, alpha="test", double_sided=name != "tufts"), tile
        )
