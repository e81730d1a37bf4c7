"""Synthetic motion of a head in a virtual-reality headset, in place of NSRR's recordings (section 3.4).

NSRR's recordings are not public, and the paper only describes them as "large rotation and translation" (section 1).
Other sources: the minimum-jerk profile (Flash and Hogan 1985) and the lever of the neck (defaults of the Oculus SDK).
All other numbers are our own, plausible for a person who stands or strolls in a room and looks around.
"""

import numpy as np

from supersampling.render.rail import FRAMES_PER_SECOND, Poses, Rail, directions
from supersampling.scenes.scene import Route, Vector

_NECK_FORWARD, _NECK_UP = 0.0805, 0.075  # metres from the neck's joint to the eyes
_FARTHEST = np.radians(110.0)  # largest turn of the head from the body's heading
_PEAK = 1.875  # top speed of a minimum-jerk move divided by its mean speed


def minimum_jerk(part: Vector) -> Vector:
    """Return positions in [0, 1] at parts of a move's duration, at rest before 0 and after 1 (Flash and Hogan 1985)."""
    s = np.clip(part, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def _turns(rng: np.random.Generator, t: Vector) -> tuple[Vector, Vector]:
    """Return yaw and pitch ``(T,)`` in radians from the body's heading: quick turns of 20 to 90 degrees with pauses.

    The larger a turn the quicker: peaks of 100 degrees per second at 20 degrees and 250 at 90, each within 15%.
    """
    gaze = np.array((rng.uniform(-0.6, 0.6), rng.uniform(-0.25, 0.1)))
    begin = -rng.uniform(0.0, 1.2)  # seconds; the clip begins anywhere in a turn or a pause
    angles = np.tile(gaze, (len(t), 1))
    while begin < t[-1]:
        turn = np.radians(rng.uniform(20.0, 90.0)) * rng.choice((-1.0, 1.0))
        turn = turn if abs(gaze[0] + turn) <= _FARTHEST else -turn
        aim = np.array((gaze[0] + turn, np.radians(rng.uniform(-25.0, 15.0))))
        size = float(np.linalg.norm(aim - gaze))
        peak = np.radians(np.interp(np.degrees(size), (20.0, 90.0), (100.0, 250.0))) * rng.uniform(0.85, 1.15)
        duration = _PEAK * size / peak
        angles += minimum_jerk((t - begin) / duration)[:, None] * (aim - gaze)
        gaze, begin = aim, begin + duration + rng.uniform(0.2, 1.2)
    return angles[:, 0], angles[:, 1]


def _lean(rng: np.random.Generator, t: Vector) -> Vector:
    """Return metres ``(T,)`` that the body leans forwards (up to 0.2) or backwards (up to 0.12), move after move."""
    position, begin = rng.uniform(-0.05, 0.1), -rng.uniform(0.0, 1.0)
    lean = np.full(len(t), position)
    while begin < t[-1]:
        aim, duration = rng.uniform(-0.12, 0.2), rng.uniform(0.6, 1.2)
        lean += minimum_jerk((t - begin) / duration) * (aim - position)
        position, begin = aim, begin + duration + rng.uniform(0.2, 0.8)
    return lean


def _tremor(rng: np.random.Generator, t: Vector) -> Vector:
    """Return angles ``(T,)`` in radians: three waves of 4 to 10 Hz and 0.01 to 0.03 degrees."""
    waves = zip(rng.uniform(4.0, 10.0, 3), rng.uniform(0.0, 1.0, 3), np.radians(rng.uniform(0.01, 0.03, 3)))
    return np.sum([size * np.sin(2.0 * np.pi * (frequency * t + phase)) for frequency, phase, size in waves], axis=0)


def from_neck(yaw: Vector, pitch: Vector) -> Vector:
    """Return vectors ``(T, 3)`` from the neck's joint to the eyes."""
    return _NECK_FORWARD * directions(yaw, pitch) + _NECK_UP * directions(yaw, pitch + 0.5 * np.pi)


def _wave(rng: np.random.Generator, t: Vector, frequency: float, low: float, high: float) -> Vector:
    return rng.uniform(low, high) * np.sin(2.0 * np.pi * (frequency * t + rng.uniform()))


def head(route: Route, rng: np.random.Generator, frames: int) -> Poses:
    """Return poses of a head: quick large turns with pauses, bob, sway, leaning and tremor.

    Six clips in ten stroll at 0.4 to 1.2 m/s, the others stand. A strolling head bobs by 1.5 to 2.5 cm at the steps'
    1.6 to 2.1 Hz, and sways by 1.5 to 2.5 cm and rolls by up to a degree at half that frequency; a standing head sways
    by 0.4 to 1 cm at 0.2 to 0.5 Hz. The eyes stay within half a metre of the route.
    """
    rail = Rail.sample(route, rng)
    t = np.arange(frames) / FRAMES_PER_SECOND
    strolls = bool(rng.random() < 0.6 and rail.length > 0.0)
    speed = rng.uniform(0.4, 1.2) if strolls else 0.0
    eye, body, slope = rail.poses(rail.ride(rng, speed, np.arange(frames, dtype=np.float64)))
    body = body + (rng.uniform(-np.pi, np.pi) if rail.aimless else 0.0)
    aside, up = _turns(rng, t)
    yaw, pitch = body + aside + _tremor(rng, t), slope + up + _tremor(rng, t)

    level = np.zeros(frames)
    ahead, right = directions(body, level), directions(body + 0.5 * np.pi, level)
    step = rng.uniform(1.6, 2.1) if strolls else rng.uniform(0.4, 1.0)
    least, most = (0.015, 0.025) if strolls else (0.004, 0.01)
    bob = _wave(rng, t, step, least, most) if strolls else level
    sway = _wave(rng, t, 0.5 * step, least, most)
    roll = _wave(rng, t, 0.5 * step, 0.003, 0.017 if strolls else 0.006) + _tremor(rng, t)
    eye = eye + _lean(rng, t)[:, None] * ahead + sway[:, None] * right
    eye = eye + from_neck(yaw, pitch) - from_neck(body, level)
    eye[:, 1] += bob
    return Poses(eye, directions(yaw, pitch), roll)
