"""Walking robots of rigid limbs: their shapes (forward is +x, up +y, right +z), and of six-legged creatures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.kit.builder import Part
from supersampling.scenes.kit.motion import rotation
from supersampling.scenes.kit.shapes import Shape, beam, box, cylinder, join, lathe, sphere, tube
from supersampling.scenes.kit.skins import outline, skin
from supersampling.scenes.kit.wheels import disc

THIGH, SHIN, ANKLE = 0.46, 0.4, 0.1  # lengths of the limbs; height of the ankle above the sole
LEG = THIGH + SHIN
HEAD = 1.95  # height of a robot's top


@dataclass(frozen=True)
class Coat:
    """Materials of one robot: plates, joints, bare metal, glowing parts."""

    plate: int
    joint: int
    metal: int
    glow: int


def casing(profile: ArrayLike, power: float = 0.45, columns: int = 14) -> Shape:
    """Return a closed shell of rounded rectangles ``profile (R, 3)``, top to bottom, with metric uv.

    A row is y, half length (x) and half width (z).
    """
    rows = np.asarray(profile, float)
    ring = outline(1.0, 1.0, columns, power)
    ring = np.concatenate([ring, ring[:1]])
    ends = [rows[:1] * [1, 0.02, 0.02], rows, rows[-1:] * [1, 0.02, 0.02]]
    rows = np.concatenate(ends)
    points = np.stack(
        [rows[:, 1:2] * ring[None, :, 0], np.repeat(rows[:, :1], columns + 1, 1), rows[:, 2:] * ring[None, :, 1]], -1
    )
    # The outline runs from +x towards -z, that is to the right as seen from outside.
    around = np.linspace(0, 4 * float(rows[:, 1:].max(0).sum()), columns + 1)
    down = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))])
    return skin(points, np.stack(np.broadcast_arrays(around, down[:, None]), -1))


def _limb(length: float, top: float, foot: float) -> list[Shape]:
    """Return a tapering case that hangs down from a joint, with an inner rod."""
    shell = casing(
        [
            (-0.05, top * 0.8, top * 0.7),
            (-0.09, top, top * 0.85),
            (-0.55 * length, 0.85 * top, 0.75 * top),
            (-length + 0.06, foot, foot * 0.9),
            (-length + 0.03, foot * 0.8, foot * 0.7),
        ]
    )
    return [shell, cylinder(0.035, length, 10).shift(0, -length / 2, 0)]


def torso(coat: Coat, kind: int) -> list[Part]:
    """Return the pelvis, chest and pack; the origin is between the hips."""
    chest = casing(
        [
            (0.62, 0.12, 0.2),
            (0.6, 0.16, 0.3),
            (0.5, 0.19, 0.34),
            (0.34, 0.17, 0.27),
            (0.24, 0.12, 0.17),
            (0.22, 0.1, 0.14),
        ]
    )
    pelvis = casing([(0.1, 0.1, 0.14), (0.06, 0.14, 0.2), (-0.04, 0.13, 0.17), (-0.08, 0.08, 0.08)])
    waist = [cylinder(0.085, 0.2, 14).shift(0, 0.16, 0)]
    waist += [lathe([(0.1, 0.012), (0.1, -0.012)], 16).shift(0, 0.1 + 0.04 * k, 0) for k in range(4)]
    waist += [disc(0.1, 0.14, (0, 0.52, s * 0.38), segments=18) for s in (-1, 1)]
    waist += [disc(0.075, 0.12, (0, 0, s * 0.17), segments=16) for s in (-1, 1)]
    pack = [box((0.16, 0.34, 0.36), (-0.23, 0.44, 0)), cylinder(0.06, 0.4, 12).shift(-0.33, 0.46, 0.1)]
    pack += [cylinder(0.06, 0.4, 12).shift(-0.33, 0.46, -0.1)]
    pack += [tube([(-0.3, 0.3, s * 0.15), (-0.2, 0.15, s * 0.22), (0.02, 0.1, s * 0.17)], 0.018, 8) for s in (-1, 1)]
    bars = [box((0.02, 0.022, 0.26), (0.175, 0.46 + 0.05 * k, 0)) for k in range(3)]
    if kind % 2:
        bars = [disc(0.075, 0.03, (0.182, 0.48, 0), "x", 20)]
        pack += [beam((-0.25, 0.6, s * 0.12), (-0.32, 1.05, s * 0.16), 0.018) for s in (-1, 1)]
    return [
        (join([chest, pelvis]), coat.plate),
        (join(waist), coat.joint),
        (join(pack), coat.metal),
        (join(bars), coat.glow),
    ]


def head(coat: Coat, kind: int) -> list[Part]:
    """Return a head on a neck; the origin is the neck's foot."""
    neck = [cylinder(0.06, 0.1, 12).shift(0, 0.04, 0), disc(0.05, 0.27, (0, 0.17, 0), segments=14)]
    if kind % 3 == 0:
        skull = casing(
            [(0.31, 0.06, 0.06), (0.29, 0.11, 0.11), (0.18, 0.14, 0.125), (0.1, 0.12, 0.11), (0.07, 0.08, 0.08)], 0.7
        )
        eyes = [box((0.03, 0.035, 0.19), (0.13, 0.19, 0))]
    elif kind % 3 == 1:
        skull = casing([(0.28, 0.11, 0.13), (0.26, 0.14, 0.16), (0.12, 0.15, 0.16), (0.08, 0.11, 0.12)], 0.3)
        eyes = [disc(0.035, 0.04, (0.15, 0.19, s * 0.075), "x", 14) for s in (-1, 1)]
        neck += [beam((0, 0.25, s * 0.14), (-0.03, 0.42, s * 0.17), 0.014) for s in (-1, 1)]
    else:
        skull = sphere(0.15, 22).shift(0, 0.18, 0)
        eyes = [disc(0.06, 0.06, (0.13, 0.2, 0), "x", 18)]
        neck.append(cylinder(0.012, 0.2, 6).shift(-0.05, 0.38, 0.05))
    return [(skull, coat.plate), (join(neck), coat.joint), (join(eyes), coat.glow)]


def arm(coat: Coat, side: int, kind: int) -> tuple[list[Part], list[Part]]:
    """Return the upper arm, hanging from the shoulder, and the forearm with hand or tool, hanging from the elbow."""
    pad = casing([(0.1, 0.06, 0.04), (0.08, 0.12, 0.09), (-0.02, 0.14, 0.11), (-0.06, 0.12, 0.1)], 0.6).shift(
        0, 0, side * 0.03
    )
    upper = [*_limb(0.32, 0.062, 0.05), pad]
    fore = _limb(0.3, 0.055, 0.06)
    hand = [box((0.07, 0.09, 0.05), (0.0, -0.33, 0))]
    hand += [beam((dx, -0.36, 0.0), (dx + 0.03, -0.45, 0), 0.02) for dx in (-0.03, 0.0, 0.03)]
    if side > 0 and kind % 2 == 0:
        hand += [cylinder(0.025, 1.5, 10).transform(rotation((0, 0, 1), 1.35)).shift(0.25, -0.32, 0)]
        hand += [
            lathe([(0.0, 0.2), (0.05, 0.06), (0.0, 0.0)], 8)
            .transform(rotation((0, 0, 1), 1.35 - np.pi))
            .shift(0.95, -0.478, 0)
        ]
    elif side < 0 and kind % 3 != 2:
        shield = casing([(0.03, 0.34, 0.03), (0.0, 0.36, 0.05), (-0.5, 0.3, 0.05), (-0.72, 0.12, 0.04)], 0.5)
        return [(join(upper), coat.plate), (disc(0.05, 0.12, (0, -0.32, 0)), coat.joint)], [
            (join([*fore, shield.shift(0, 0.1, -0.12)]), coat.plate),
            (join(hand), coat.metal),
        ]
    return [(join(upper), coat.plate), (disc(0.05, 0.12, (0, -0.32, 0)), coat.joint)], [
        (join(fore), coat.plate),
        (join(hand), coat.metal),
    ]


def leg(coat: Coat) -> tuple[list[Part], list[Part], list[Part]]:
    """Return the thigh, shin and foot, each hanging from its joint."""
    knee = disc(0.065, 0.15, (0, -THIGH, 0), segments=16)
    cap = casing([(0.08, 0.03, 0.05), (0.06, 0.05, 0.07), (-0.07, 0.04, 0.06), (-0.1, 0.02, 0.03)])
    shin = join([*_limb(SHIN + 0.04, 0.07, 0.05), cap.shift(0.06, 0, 0)])
    pistons = [beam((-0.07, -0.05, s * 0.03), (-0.05, -SHIN + 0.04, s * 0.03), 0.02) for s in (-1, 1)]
    sole = casing([(0.02, 0.05, 0.05), (0.0, 0.07, 0.07), (-0.05, 0.15, 0.08), (-ANKLE, 0.16, 0.085)], 0.4)
    foot = [(sole.shift(0.06, 0, 0), coat.plate), (disc(0.05, 0.15, (0, 0, 0), segments=14), coat.joint)]
    thigh = [(join(_limb(THIGH, 0.095, 0.07)), coat.plate), (knee, coat.joint)]
    return thigh, [(shin, coat.plate), (join(pistons), coat.metal)], foot
