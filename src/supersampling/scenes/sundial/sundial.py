"""The built-in scene ``sundial``: a painted court and a lamp chamber that stand still, while shadows turn over them.

Both rooms are convex except for mouldings of a few centimetres, so that a camera in them uncovers next to nothing. The
objects that cast the shadows hang above the view: the motion vectors are those of the walls, yet the picture changes.
"""

import numpy as np

from supersampling.scenes.kit.blocks import beam, box, panel, quad
from supersampling.scenes.kit.builder import Builder
from supersampling.scenes.kit.motion import chain, fixed, rotation, spin, sway, translation
from supersampling.scenes.kit.routes import tripod, walk
from supersampling.scenes.kit.shapes import Point, cylinder, grid, join
from supersampling.scenes.kit.site import Site
from supersampling.scenes.scene import PointLight, Route, Scene, Sky, Sun
from supersampling.scenes.sundial import parts
from supersampling.scenes.sundial.materials import Palette

HALF = (8.0, 7.0)  # metres from the court's middle to its walls, in x and z
TOP, DADO, FRIEZE = 5.3, 1.15, 4.4
CHAMBER, APOTHEM, CEILING = (-22.0, 0.0), 4.8, 6.6
LAMP = (CHAMBER[0], 5.0, CHAMBER[1])
RELIEF = 0.05  # what a moulding may stand out from its wall, metres
SUN = (0.42, 0.76, 0.5)


def _wall(site: Site, p: Palette, width: float, bays: int, door: int) -> None:
    """Add a wall of the court along the local x from 0, facing +z.

    It has a dado, a painted arcade, a frieze, a coping, and a door in one bay.
    """
    site.put(panel((0, DADO, 0), (width, 0, 0), (0, -DADO, 0)), p.dado)
    site.put(box((width, 0.09, 0.04), (width / 2, DADO, 0.02), ("front", "top", "bottom")), p.lime, (0.78, 0.6, 0.46))
    site.put(box((width, 0.12, 0.03), (width / 2, 0.06, 0.015), ("front", "top")), p.lime, (0.5, 0.42, 0.36))
    step = width / bays
    for k in range(bays):
        site.put(quad((k * step, FRIEZE, 0), (step, 0, 0), (0, DADO - FRIEZE, 0)), p.bays[k % 2])
    high = 0.42
    site.put(quad((0, FRIEZE + high, 0), (width, 0, 0), (0, -high, 0)).map_uv((round(width / high), 1)), p.frieze)
    site.put(panel((0, TOP, 0), (width, 0, 0), (0, FRIEZE + high - TOP, 0)), p.lime)
    site.put(box((width + 1.0, 0.16, 0.6), (width / 2, TOP + 0.06, -0.26)), p.lime, (0.78, 0.5, 0.36))
    site.put(panel((width + 0.5, TOP, -0.5), (-width - 1.0, 0, 0), (0, -TOP, 0)), p.lime)
    middle = (door + 0.5) * step
    leaf = [box((1.3, 2.3, 0.02), (middle, 1.15, 0.012), ("front", "left", "right", "top"))]
    leaf += [box((0.09, 2.3, 0.045), (middle + x, 1.15, 0.022)) for x in (-0.66, 0.0, 0.66)]
    leaf += [box((1.41, 0.1, 0.045), (middle, y, 0.022)) for y in (0.09, 0.86, 1.5, 2.34)]
    site.put(join(leaf), p.wood)


def _court(b: Builder, p: Palette) -> None:
    """Add four walls and the floor with the dial's hour lines and two arcs let into it."""
    x, z = HALF
    for turn, at, width, bays, door in (
        (0, (-x, -z), 2 * x, 6, 3),
        (-90, (x, -z), 2 * z, 5, 1),
        (180, (x, z), 2 * x, 6, 1),
        (90, (-x, z), 2 * z, 5, 4),
    ):
        _wall(Site(b, turn, *at), p, width, bays, door)
    b.put(panel((-x, 0, -z), (2 * x, 0, 0), (0, 0, 2 * z)), p.paving)
    dark = (0.2, 0.13, 0.11)
    foot = (0.0, 5.2)
    for hour in range(-5, 6):
        angle = np.radians(14.5 * hour)
        across, back = np.sin(angle), -np.cos(angle)
        reach = min((x - 0.6) / max(abs(across), 1e-6), (z - 0.6 + foot[1]) / max(-back, 1e-6))
        line = box((0.07, 0.006, reach - 1.3), (0, 0.0, -(reach + 1.3) / 2), ("top",)).turn_y(-float(np.degrees(angle)))
        b.put(line.shift(foot[0], 0, foot[1]), p.lime, dark)
    for radius in (1.3, 4.6, 8.2):
        span = np.linspace(1.3, -1.3, 41) if radius < 8 else np.linspace(0.88, -0.88, 41)
        way = np.stack([-np.sin(span), 0 * span, -np.cos(span)], 1)
        rows = np.stack([way * (radius + 0.05), way * (radius - 0.05)]) + np.array((foot[0], 0.003, foot[1]))
        up = np.broadcast_to([0.0, 1.0, 0.0], rows.shape)
        b.put(grid(rows, up, rows[..., (0, 2)]), p.lime, dark)


def _chamber(b: Builder, p: Palette) -> None:
    """Add eight walls, a floor, a slab for a ceiling: dim, with the lamp high up in the middle."""
    side = 2 * APOTHEM * np.tan(np.pi / 8)
    for k in range(8):
        angle = k * 45.0
        site = Site(b, angle, *CHAMBER)
        left = (-side / 2, -APOTHEM)
        site.put(panel((left[0], 1.0, left[1]), (side, 0, 0), (0, -1.0, 0)), p.dado, (0.86, 0.78, 0.68))
        site.put(box((side, 0.07, 0.04), (0, 1.0, -APOTHEM + 0.02), ("front", "top", "bottom")), p.wood)
        site.put(panel((left[0], CEILING, left[1]), (side, 0, 0), (0, 1.0 - CEILING, 0)), p.stucco)
        site.put(panel((side / 2, CEILING, -APOTHEM - 0.3), (-side, 0, 0), (0, -CEILING, 0)), p.lime)
        site.put(box((side, 0.16, 0.04), (0, 5.4, -APOTHEM + 0.02), ("front", "top", "bottom")), p.wood)
    x, z = CHAMBER
    wide = 2 * (APOTHEM + 0.5)
    b.put(panel((x - wide / 2, 0, z - wide / 2), (wide, 0, 0), (0, 0, wide)), p.paving, (0.86, 0.72, 0.6))
    b.put(box((wide, 0.3, wide), (x, CEILING + 0.15, z)), p.lime, (0.7, 0.6, 0.5))
    b.put(cylinder(0.02, CEILING - LAMP[1] - 0.36, 8).shift(x, (CEILING + LAMP[1] + 0.36) / 2, z), p.wood)


def _frames(b: Builder, p: Palette) -> None:
    """Add masts, beams and trestles that carry what moves; none of them is in view."""
    for x in (1.2, 9.6):
        b.put(beam((x, 0, 8.4), (x, 12.6, 8.4), 0.3), p.wood)
    timber = [beam((-1.6, y, 8.4), (9.8, y, 8.4), 0.22) for y in (12.3, 11.6)]
    timber += [beam((6.6, 12.3, 8.5), (6.6, 11.3, 6.7), 0.14), beam((6.6, 11.3, 6.7), (6.6, 11.0, 6.7), 0.14)]
    timber += [beam((-1.2, 12.3, 8.4), (-1.2, 11.0, 7.6), 0.14), beam((4.4, 12.3, 8.4), (4.4, 11.0, 3.8), 0.14)]
    timber += [beam((x, 11.6, 8.4), (x, 11.2, 7.0), 0.08) for x in (-0.8, 8.4)] + [
        beam((-1.4, 11.2, 7.0), (9.6, 11.2, 7.0), 0.07)
    ]
    for (x, y, z), feet in (
        ((8.6, 16.0, 2.1), ((9.2, 1.2), (9.2, 3.4), (11.0, 2.6))),
        ((-1.0, 15.0, 6.8), ((0.4, 7.9), (2.6, 7.9), (1.4, 10.4))),
    ):
        top = (x + 0.45, y, z + 0.55)
        timber += [beam((fx, 0, fz), top, 0.16) for fx, fz in feet] + [beam((x, y, z), top, 0.3)]
    b.put(join(timber), p.wood)


def _movers(b: Builder, p: Palette) -> None:
    """Add two mills, a slatted wheel, a lattice drum and banners over the court; lampshade and star in the chamber."""
    facing = float(np.degrees(np.arctan2(SUN[0], SUN[2])))
    laths, canvas = parts.sails(5.2)
    for k, (at, hertz) in enumerate((((8.6, 16.0, 2.1), 0.034), ((-1.0, 15.0, 6.8), -0.027))):
        turn = rotation((0, 1, 0), np.radians(facing))
        place = translation(at) @ turn
        b.move([(laths, p.wood), (canvas, p.lime)], chain(fixed(place), spin((0, 0, 0), (0, 0, 1), hertz, 0.6 * k)))
    b.move([(parts.slatted_wheel(3.1), p.wood)], spin((6.6, 11.0, 6.7), (0, 1, 0), 0.045))
    level = translation((1.6, 11.0, 5.7)) @ rotation((0, 1, 0), np.radians(34))
    b.move([(parts.lattice_drum(1.7, 6.2), p.wood)], chain(fixed(level), spin((0, 0, 0), (1, 0, 0), 0.05)))
    cloth = parts.banner(1.5, 2.3)
    for k in range(5):
        b.move([(cloth, p.lime)], sway((-0.3 + 2.2 * k, 11.14, 7.0), (1, 0.1, 0), 17.0, 0.14 + 0.013 * k, 1.3 * k))
    b.move([(parts.pierced_shade(0.46, 0.72), p.lime)], spin(LAMP, (0, 1, 0), 0.03))
    b.move([(parts.star_plate(0.42), p.lime)], spin((LAMP[0], LAMP[1] - 0.38, LAMP[2]), (0, 1, 0), -0.05))


def _in_chamber(degrees: float, radius: float, y: float) -> Point:
    """Return a point of the chamber by its bearing from the lamp."""
    a = np.radians(degrees)
    return (CHAMBER[0] + radius * float(np.sin(a)), y, CHAMBER[1] + radius * float(np.cos(a)))


def _routes() -> list[Route]:
    """Return walks and tripods in both rooms, all looking at walls and floor.

    Each split has both rooms and a standing camera.
    """

    def chamber_walk(name: str, start: float) -> Route:
        eyes = [_in_chamber(start + a, 3.5, 1.65) for a in (0, 30, 60, 90)]
        return walk(name, eyes, [_in_chamber(start + 180 + a, 4.5, 0.9) for a in (-10, 30, 70, 110)])

    return [
        walk("north wall", [(-5.5, 1.65, 4.4), (2.6, 1.6, 4.6)], [(-3.0, 1.2, -7.0), (2.6, 1.2, -7.0)]),
        walk("towards the north-west", [(5.6, 1.65, 3.4), (0.4, 1.65, 2.6)], [(-4.0, 0.9, -6.0), (-8.0, 0.9, -5.0)]),
        tripod("tripod before the dial", (0.6, 1.6, 5.6), (-1.2, 0.8, -5.0)),
        walk("west wall", [(4.6, 1.65, -4.4), (4.2, 1.6, 2.4)], [(-8.0, 1.0, -2.4), (-8.0, 1.0, 0.6)]),
        chamber_walk("round the lamp", 20.0),
        tripod("tripod in the chamber", _in_chamber(-30, 4.1, 1.5), _in_chamber(160, 4.8, 1.1)),
        walk("along the west wall", [(-4.6, 1.6, 5.2), (-4.9, 1.6, -0.6)], [(-6.4, 1.0, -4.0), (-5.4, 0.9, -7.0)]),
        tripod("tripod towards the west wall", (5.4, 1.6, 1.8), (-5.6, 0.9, -1.6)),
        tripod("tripod by the chamber's wall", _in_chamber(100, 4.2, 1.55), _in_chamber(-95, 4.8, 0.9)),
        chamber_walk("round the lamp, far side", 140.0),
        tripod("tripod over the floor", (-6.6, 2.1, 4.4), (-1.0, -0.4, -4.0)),
        walk("over the dial's lines", [(-1.4, 1.7, 5.4), (3.9, 1.7, 4.9)], [(-4.6, 0.6, -4.0), (1.0, 0.7, -6.0)]),
    ]


def sundial() -> Scene:
    """Build a court under turning sails and a chamber round a turning lamp: only light and shadow move in view."""
    b = Builder()
    p = Palette(b)
    _court(b, p)
    _chamber(b, p)
    _frames(b, p)
    _movers(b, p)
    meshes, objects = b.build()
    return Scene(
        "sundial",
        b.materials,
        meshes,
        objects,
        _routes(),
        sun=Sun(SUN, (4.8, 4.1, 3.2)),
        points=[PointLight(LAMP, (62.0, 41.0, 22.0), 14.0)],
        sky=Sky((0.2, 0.36, 0.74), (0.62, 0.68, 0.78), (0.26, 0.23, 0.2), 0.55),
        exposure=0.56,
        near=0.1,
        far=90.0,
        attribution="Code: MIT. Gravel: scikit-image's photograph, CC0.",
    )
