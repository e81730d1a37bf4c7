"""Materials of the foundry."""

from dataclasses import dataclass

from supersampling.scenes.kit import lettering, metal, textures
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.dials import gauge
from supersampling.scenes.scene import Material


@dataclass(frozen=True)
class Stock:
    """Indices of the foundry's materials in its builder."""

    floor: int
    hazard: int
    green: int
    red: int
    yellow: int
    sheet: int
    brick: int
    tread: int
    steel: int
    brass: int
    iron: int
    fence: int
    grate: int
    wood: int
    crates: int
    embers: int
    lamp: int
    gauges: tuple[int, ...]
    notices: tuple[int, ...]


def _maps(maps: textures.Maps, name: str, metallic: float = 0.0) -> Material:
    albedo, normal, surface = maps
    return Material(name, albedo, normal, surface, roughness=1.0, metallic=metallic)


def _lattice(name: str, cells: int, bar: float, slant: bool) -> Material:
    albedo = textures.lattice(256, cells, bar, (0.72, 0.7, 0.66), 5, slant)
    return Material(name, albedo, roughness=0.45, metallic=0.5, alpha="test", double_sided=True)


def _notices(builder: Builder) -> tuple[int, ...]:
    texts = [
        lettering.notice(1, "DANGER", (232, 190, 40), (20, 20, 20)),
        lettering.notice(2, "SAFETY RULES", (238, 234, 222), (30, 40, 90)),
        lettering.notice(3, "HOT METAL", (190, 42, 32), (245, 238, 225)),
        lettering.notice(4, "SHIFT PLAN", (205, 222, 205), (18, 50, 30)),
        lettering.poster(5, (40, 70, 110), (235, 220, 180), "MIND THE GEARS"),
    ]
    return tuple(builder.material(Material(f"notice {i}", t, roughness=0.6)) for i, t in enumerate(texts))


def _gauges(builder: Builder) -> tuple[int, ...]:
    units = ("bar", "kN", "rpm")
    return tuple(builder.material(Material(u, gauge(i, u), roughness=0.3)) for i, u in enumerate(units))


def stock(builder: Builder) -> Stock:
    """Add the foundry's materials."""
    green = [(0.1, 0.22, 0.17), (0.2, 0.42, 0.32), (0.38, 0.58, 0.46)]
    red = [(0.3, 0.07, 0.05), (0.56, 0.15, 0.1), (0.72, 0.3, 0.2)]
    yellow = [(0.55, 0.36, 0.04), (0.82, 0.6, 0.1), (0.95, 0.8, 0.3)]
    blue = [(0.28, 0.36, 0.42), (0.46, 0.56, 0.62), (0.66, 0.74, 0.78)]
    clay = [(0.36, 0.15, 0.1), (0.6, 0.28, 0.18), (0.76, 0.46, 0.32)]
    grey = [(0.3, 0.3, 0.31), (0.6, 0.6, 0.6), (0.85, 0.84, 0.82)]
    dark = [(0.12, 0.12, 0.13), (0.3, 0.29, 0.28), (0.5, 0.47, 0.44)]
    gold = [(0.4, 0.26, 0.1), (0.76, 0.56, 0.25), (0.95, 0.82, 0.5)]
    pine = [(0.26, 0.16, 0.08), (0.55, 0.38, 0.2), (0.74, 0.56, 0.34)]
    albedo, normal, glow = metal.embers(512, 90)
    embers = Material("embers", albedo, normal, glow, roughness=1.0, emission=(0.9, 0.6, 0.4))
    add = builder.material
    return Stock(
        floor=add(_maps(metal.concrete(512, 10), "concrete"), 2.0),
        hazard=add(_maps(metal.hazard(512, 20), "hazard paint"), 1.0),
        green=add(_maps(metal.riveted(512, 30, green), "green plate", 1.0), 1.6),
        red=add(_maps(metal.riveted(512, 35, red), "red plate", 1.0), 1.2),
        yellow=add(_maps(metal.riveted(512, 40, yellow), "yellow plate", 1.0), 1.2),
        sheet=add(_maps(metal.corrugated(512, 45, blue), "corrugated sheet"), 1.8),
        brick=add(_maps(textures.bricks(512, 16, 6, clay, 50), "brick"), 1.5),
        tread=add(_maps(metal.tread(512, 55), "checker plate", 1.0), 0.7),
        steel=add(_maps(metal.brushed(512, 60, grey), "steel", 1.0), 0.7),
        brass=add(_maps(metal.brushed(512, 65, gold), "brass", 1.0), 0.5),
        iron=add(_maps(metal.brushed(512, 70, dark, 0.3), "iron", 1.0), 0.5),
        fence=add(_lattice("fence", 8, 0.16, True), 0.4),
        grate=add(_lattice("grate", 8, 0.3, False), 0.4),
        wood=add(_maps(textures.wood(512, 75, pine, 6), "pine"), 1.0),
        crates=add(Material("crates", lettering.label_sheet(80), roughness=0.7)),
        embers=add(embers, 1.5),
        lamp=add(Material("lamp", base_color=(1.0, 0.95, 0.85), emission=(6.0, 5.2, 4.0))),
        gauges=_gauges(builder),
        notices=_notices(builder),
    )
