"""Planes, trucks and drones of the airstrip, in their own frames: nose along +x, up +y, right +z."""

from functools import cache

import numpy as np

from supersampling.scenes.airstrip.shapes import hull, propeller, upright, wheel, wing
from supersampling.scenes.kit.builder import Part
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, lathe, quad, sphere

AXLES = (1.35, -1.25)  # x of a truck's axles
TYRE = 0.42
NOSE = (2.5, 0.0, 0.0)  # where a plane's propeller turns
ARMS = tuple((x, 0.12, z) for x in (-0.55, 0.55) for z in (-0.55, 0.55))  # a drone's rotors
WHEELS_DOWN = 1.12  # height of a plane's origin above the ground it stands on

_BODY = (  # stations of the fuselage, as `hull` takes them
    (-2.85, 0.12, 0.08, 0.02),
    (-2.6, 0.1, 0.17, 0.07),
    (-1.9, 0.08, 0.24, 0.15),
    (-1.0, 0.06, 0.37, 0.28),
    (-0.2, 0.05, 0.5, 0.38),
    (0.6, 0.02, 0.53, 0.44),
    (1.3, 0.0, 0.5, 0.47),
    (1.45, 0.0, 0.52, 0.5),
    (2.1, 0.0, 0.49, 0.47),
    (2.36, 0.0, 0.4, 0.39),
    (2.42, 0.0, 0.3, 0.3),
    (2.4, 0.0, 0.16, 0.16),
    (2.38, 0.0, 0.01, 0.01),
)


def plane(livery: int, metal: int, glass: int, biplane: bool) -> list[Part]:
    """Return a racing plane 5.4 m long with 6.4 m of span; a second wing with struts when ``biplane``."""
    return list(zip(_airframe(biplane), (livery, metal, glass)))


@cache
def _airframe(biplane: bool) -> tuple[Shape, Shape, Shape]:
    """Return the skins, the rods and wheels, and the canopy."""
    half = 3.2
    span = np.linspace(-1, 1, 17)
    tip = 1 - np.abs(span) ** 6
    main = np.stack(
        [
            half * span,
            -0.3 + 0.22 * np.abs(span),
            0.95 - 0.22 * np.abs(span),
            (1.4 - 0.5 * np.abs(span)) * (0.35 + 0.65 * tip),
            0.17 * tip + 0.01,
        ],
        1,
    )
    wings = [wing(main)]
    if biplane:
        wings.append(wing(main * [0.95, 1, 1, 0.9, 0.9] + [0, 1.35, 0.2, 0, 0]))
    tail = np.linspace(-1, 1, 9)
    plan = np.stack(
        [
            1.25 * tail,
            0 * tail + 0.16,
            -1.95 - 0.25 * np.abs(tail),
            0.8 - 0.35 * np.abs(tail),
            0.07 * (1 - tail**6) + 0.01,
        ],
        1,
    )
    rudder = np.stack(
        [
            np.linspace(0.05, 1.05, 6),
            np.zeros(6),
            np.linspace(-1.9, -2.4, 6),
            np.linspace(0.95, 0.5, 6),
            [0.08, 0.08, 0.07, 0.06, 0.04, 0.01],
        ],
        1,
    )
    skins = [hull(_BODY).map_uv((1, 0.5)), *wings, wing(plan), upright(wing(rudder))]
    canopy = hull(
        [
            (-0.95, 0.36, 0.05, 0.04),
            (-0.7, 0.42, 0.2, 0.16),
            (-0.2, 0.46, 0.34, 0.26),
            (0.3, 0.46, 0.36, 0.28),
            (0.62, 0.44, 0.26, 0.24),
            (0.9, 0.42, 0.06, 0.1),
        ],
        9,
    )
    return join(skins), _rigging(biplane), canopy


def _rigging(biplane: bool) -> Shape:
    """Return struts, wheels, exhausts and the frame of the canopy."""
    rods = [beam((0.7, -0.35, s * 0.5), (0.75, -0.85, s * 0.85), 0.07) for s in (-1, 1)]
    rods += [beam((-2.5, 0.0, 0), (-2.6, -0.25, 0), 0.05)]
    if biplane:
        for s in (-1, 1):
            for x, lean in ((0.75, 0.2), (-0.1, 0.15)):
                rods.append(beam((x, -0.15, s * 2.1), (x + lean, 1.2, s * 2.05), 0.05, 0.09))
                rods.append(beam((x - 0.1, 0.45, s * 0.3), (x + 0.1, 1.08, s * 0.5), 0.04))
            rods.append(beam((0.75, -0.25, s * 0.5), (0.9, 1.2, s * 2.05), 0.015))
    wheels = [wheel(0.27, 0.16).shift(0.75, -0.85, s * 0.9) for s in (-1, 1)]
    wheels.append(wheel(0.11, 0.07).shift(-2.6, -0.3, 0))
    pots = [
        cylinder(0.05, 0.5, 8).transform(rotation((0, 0, 1), np.pi / 2)).shift(1.6, -0.3, s * 0.42) for s in (-1, 1)
    ]
    frame = [box((0.04, 0.05, 0.5), (x, 0.8, 0)) for x in (-0.1, 0.3)]
    return join([*rods, *wheels, *pots, *frame])


def airscrew(metal: int) -> list[Part]:
    return [(propeller(0.98, 3), metal)]


def truck(paint: int, metal: int, glass: int, load: list[Part]) -> list[Part]:
    """Return a light lorry 4.6 m long without its wheels.

    ``load`` stands on its bed, whose top is at y = 0.85 and which reaches from x = -2.2 to 0.55.
    """
    side = np.array([(2.25, 0.5), (2.25, 1.05), (1.95, 1.25), (1.5, 2.05), (0.65, 2.05), (0.65, 0.5)])
    cab = []
    for z, order in ((0.92, 1), (-0.92, -1)):
        ring = side[::order]
        fan = np.stack([np.full(3, 0), np.arange(1, 4), np.arange(2, 5)], 1)
        fan = np.concatenate([fan, [[0, 4, 5]]])
        points = np.concatenate([ring, np.full((6, 1), z)], 1)
        normal = np.tile([0.0, 0.0, np.sign(z)], (6, 1))
        cab.append(Shape(points, normal, ring * [1, -1], fan))
    for p, q in zip(side, np.roll(side, -1, axis=0)):
        cab.append(quad((*q, 0.92), (0, 0, -1.84), (*(p - q), 0)).map_uv((1.84, float(np.linalg.norm(q - p)))))
    bed = [box((2.85, 0.12, 1.9), (-0.8, 0.79, 0)), box((0.06, 0.3, 1.9), (-2.2, 0.95, 0))]
    frame = [box((4.3, 0.2, 0.7), (0.0, 0.55, 0)), box((0.16, 0.2, 1.8), (2.28, 0.52, 0))]
    frame += [box((0.9, 0.08, 0.3), (x, 0.9, z)) for x in AXLES for z in (-0.95, 0.95)]
    frame += [box((0.05, 0.3, 0.06), (1.95, 1.5, s * 1.05)) for s in (-1, 1)]
    frame += [beam((2.27, 0.62 + 0.09 * k, -0.55), (2.27, 0.62 + 0.09 * k, 0.55), 0.03) for k in range(5)]
    frame += [box((0.08, 0.16, 0.26), (2.24, 0.86, s * 0.68)) for s in (-1, 1)]
    frame += [
        box((0.1, 0.06, 1.9), (1.0, 2.08, 0)),
        box((0.02, 1.1, 0.03), (1.08, 1.3, 0.925)),
        box((0.14, 0.04, 0.03), (0.95, 1.25, 0.94)),
    ]
    panes = [quad((1.52, 2.0, 0.85), (0, 0, -1.7), (0.4, -0.72, 0)).shift(0.015, 0.01, 0)]
    panes += [quad((0.75, 1.95, 0.932), (0.68, 0, 0), (0, -0.62, 0))]
    panes += [quad((1.43, 1.95, -0.932), (-0.68, 0, 0), (0, -0.62, 0))]
    return [(join(cab), paint), (join(bed), paint), (join(frame), metal), (join(panes), glass), *load]


def axle(metal: int) -> list[Part]:
    tyre = wheel(TYRE, 0.26)
    return [(join([tyre.shift(0, 0, z) for z in (-0.82, 0.82)]), metal)]


def tank(paint: int, metal: int) -> list[Part]:
    """Return a lying tank with lettering on both sides."""
    body = hull(
        [
            (-2.2, 1.5, 0.5, 0.62),
            (-2.1, 1.5, 0.62, 0.8),
            (-1.0, 1.5, 0.64, 0.84),
            (0.4, 1.5, 0.62, 0.8),
            (0.5, 1.5, 0.5, 0.62),
        ]
    ).map_uv((1, 2))
    caps = [box((0.02, 0.9, 1.15), (x, 1.5, 0)) for x in (-2.19, 0.49)]
    hats = [cylinder(0.16, 0.12, 14).shift(x, 2.16, 0) for x in (-1.6, -0.8, 0.0)]
    return [(body, paint), (join([*caps, *hats]), metal)]


def drone(paint: int, metal: int) -> list[Part]:
    """Return a quadcopter 1.6 m across without its rotors."""
    body = hull(
        [
            (-0.34, 0, 0.06, 0.06),
            (-0.25, 0, 0.13, 0.14),
            (0.0, 0.02, 0.16, 0.18),
            (0.25, 0, 0.12, 0.14),
            (0.36, 0, 0.05, 0.06),
        ],
        9,
    )
    arms = [beam((0, 0.02, 0), (x, 0.04, z), 0.06, 0.05) for x, _, z in ARMS]
    arms += [cylinder(0.06, 0.16, 12).shift(x, 0.05, z) for x, _, z in ARMS]
    angle = np.linspace(0, 2 * np.pi, 25)[:-1]
    hoop = lathe([(0.3, 0.02), (0.315, 0.02), (0.315, -0.02), (0.3, -0.02), (0.3, 0.02)], len(angle))
    guards = [hoop.shift(x, 0.12, z) for x, _, z in ARMS]
    legs = [beam((x, 0, z), (x * 1.2, -0.26, z * 1.2), 0.025) for x in (-0.2, 0.2) for z in (-0.15, 0.15)]
    legs += [beam((-0.3, -0.26, z), (0.3, -0.26, z), 0.03) for z in (-0.18, 0.18)]
    eye = sphere(0.09, 12).shift(0.28, -0.12, 0)
    return [(join([body, *guards]), paint), (join([*arms, *legs, eye]), metal)]


def rotor(metal: int) -> list[Part]:
    blades = [box((0.54, 0.012, 0.045)).transform(rotation((1, 0, 0), 0.25)), cylinder(0.03, 0.05, 8)]
    return [(join(blades), metal)]
