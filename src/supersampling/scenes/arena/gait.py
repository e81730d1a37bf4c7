"""Gait of the arena's figures: every part of a robot moves rigidly in its parent's frame."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from supersampling.scenes.arena.figures import ANKLE, LEG, SHIN, THIGH, Coat, arm, casing, head, leg, torso
from supersampling.scenes.kit.builder import Part
from supersampling.scenes.kit.motion import chain, rotation, sway, translation
from supersampling.scenes.kit.shapes import Shape, beam, join, lathe, sphere, tube
from supersampling.scenes.scene import Array, Transform

Add = Callable[[list[Part], Transform], None]
SWING, BEND = (0.42, 0.95)  # radians: how far a leg swings to each side, how far a knee bends on its way forward
EVEN = 0.97  # below 1: how near to a constant rate a leg swings
STRIDE = 4 * LEG * np.sin(SWING)  # metres that two steps cover


def _joint(place: ArrayLike, angle: Callable[[float], float]) -> Transform:
    """Return a rotation about the local z axis at ``place``; a positive ``angle`` swings the limb forward."""
    at_place = translation(place)

    def pose(seconds: float) -> Array:
        return (at_place @ rotation((0, 0, 1), angle(seconds))).astype(np.float32)

    return pose


def _cached(motion: Transform) -> Transform:
    """Return ``motion`` with a cache of its last moments, for the parts that move in its frame."""
    return lru_cache(maxsize=1024)(motion)


@dataclass(frozen=True)
class Step:
    """Angles of one leg (and of the arm on that side) over time; ``rate`` in steps of that leg per second."""

    rate: float
    phase: float

    def _turn(self, seconds: float) -> float:
        return 2 * np.pi * self.rate * seconds + self.phase

    def swing(self, seconds: float) -> float:
        """Return the angle of the hip: nearly even to and fro, so that the standing foot stays where it is."""
        return SWING * float(np.arcsin(EVEN * np.sin(self._turn(seconds))) / np.arcsin(EVEN))

    def bend(self, seconds: float) -> float:
        """Return the angle of the knee, bent only on the way forward."""
        return -BEND * max(float(np.cos(self._turn(seconds))), 0.0) ** 3

    def level(self, seconds: float) -> float:
        """Return the angle of the ankle, which keeps the sole level."""
        return -self.swing(seconds) - self.bend(seconds)

    def shoulder(self, seconds: float) -> float:
        return 0.05 - 0.4 * float(np.sin(self._turn(seconds)))

    def elbow(self, seconds: float) -> float:
        return 0.55 - 0.22 * float(np.sin(self._turn(seconds)))


def _bob(step: Step, size: float) -> Transform:
    """Return the motion of the body, which sinks as the legs spread: the standing leg is straight, on the ground."""

    def pose(seconds: float) -> Array:
        high = LEG * np.cos(step.swing(seconds)) + ANKLE
        return translation((0, size * high, 0)).astype(np.float32)

    return pose


def biped(add: Add, ride: Transform, speed: float, phase: float, coat: Coat, kind: int, size: float) -> None:
    """Add the twelve moving parts of a robot that walks along ``ride``; ``size`` scales it (and its stride)."""
    rate = speed / (STRIDE * size)

    def place(parts: list[Part], motion: Transform) -> None:
        scaled = [(Shape(s.positions * size, s.normals, s.uv * size, s.triangles), m) for s, m in parts]
        add(scaled, motion)

    def joint(offset: ArrayLike, angle: Callable[[float], float]) -> Transform:
        return _joint(np.asarray(offset, float) * size, angle)

    body = _cached(chain(ride, _bob(Step(rate, phase), size)))
    twist = sway((0, 0, 0), (0, 1, 0), 7, rate, phase + np.pi / 2)
    chest = _cached(chain(body, twist))
    place(torso(coat, kind), chest)
    place(head(coat, kind), chain(chest, sway(np.array([0.0, 0.62, 0.0]) * size, (0, 1, 0), 24, 0.13, phase)))
    for side in (-1, 1):
        step = Step(rate, phase + (np.pi if side < 0 else 0.0))
        thigh, shin, foot = leg(coat)
        hip = joint((0, 0, side * 0.17), step.swing)
        knee = joint((0, -THIGH, 0), step.bend)
        upper_leg = _cached(chain(body, hip))
        lower_leg = _cached(chain(upper_leg, knee))
        place(thigh, upper_leg)
        place(shin, lower_leg)
        place(foot, chain(lower_leg, joint((0, -SHIN, 0), step.level)))
        upper, fore = arm(coat, side, kind)
        shoulder = joint((0, 0.52, side * 0.44), step.shoulder)
        elbow = joint((0, -0.32, 0), step.elbow)
        place(upper, chain(chest, shoulder))
        place(fore, chain(chest, shoulder, elbow))


def crawler(add: Add, ride: Transform, speed: float, phase: float, coat: Coat) -> None:
    """Add a six-legged creature 1.6 m long: a body and six legs of one piece that row."""
    shell = casing(
        [(0.92, 0.2, 0.12), (0.88, 0.5, 0.3), (0.72, 0.68, 0.4), (0.58, 0.62, 0.36), (0.52, 0.4, 0.2)], 0.8, 24
    )
    plates = [lathe([(0.32, 0.04), (0.4, 0.0), (0.4, -0.03)], 24).shift(x, 0.87, 0) for x in (-0.3, 0.1)]
    spikes = [lathe([(0.0, 0.22), (0.05, 0.0)], 8).shift(-0.5 + 0.2 * k, 0.88, 0) for k in range(6)]
    eyes = [sphere(0.05, 12).shift(0.6, 0.78, s * 0.16) for s in (-1, 1)]
    jaws = [tube([(0.6, 0.62, s * 0.12), (0.8, 0.58, s * 0.2), (0.95, 0.56, s * 0.06)], 0.03, 8) for s in (-1, 1)]
    bob = sway((0, 0, 0), (1, 0, 0), 2.5, 2.2, phase)
    add(
        [(join([shell, *plates]), coat.plate), (join([*spikes, *jaws]), coat.metal), (join(eyes), coat.glow)],
        chain(ride, bob),
    )
    for k in range(6):
        side, x = (-1) ** k, 0.42 * (k // 2 - 1)
        bow = join(
            [
                beam((0, 0, 0), (0, 0.3, side * 0.42), 0.09, 0.07),
                beam((0, 0.3, side * 0.42), (0, -0.34, side * 0.66), 0.065, 0.08),
                lathe([(0.05, 0.0), (0.0, -0.32)], 8).shift(0, -0.32, side * 0.66),
            ]
        )
        knob = [
            sphere(0.08, 12),
            sphere(0.075, 12).shift(0, 0.3, side * 0.42),
            sphere(0.055, 10).shift(0, -0.32, side * 0.66),
        ]
        knob += [
            casing([(0.2, 0.05, 0.05), (0.0, 0.1, 0.1), (-0.22, 0.06, 0.06)], 0.7)
            .transform(rotation((1, 0, 0), -side * 0.42))
            .shift(0, 0.08, side * 0.55)
        ]
        row = sway((x, 0.64, side * 0.3), (0, 1, 0), 20, speed / 0.62, phase + np.pi * ((k // 2 + k) % 2))
        add([(bow, coat.joint), (join(knob), coat.plate)], chain(ride, row))
