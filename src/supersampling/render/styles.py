"""Styles of camera motion along a route, by the names that ``data.camera`` accepts."""

from collections.abc import Callable

import numpy as np

from supersampling.errors import UserError
from supersampling.render.head import head
from supersampling.render.rail import FRAMES_PER_SECOND, Poses, Rail, along, directions, heading, route_length
from supersampling.scenes.scene import Route, Vector

CameraStyle = Callable[[Route, np.random.Generator, int], Poses]

STOP = 10  # frames of standing (QRISP, annex A.3)
_RAMP = 6  # frames of braking, and of setting off


def _pace(rng: np.random.Generator, frames: int) -> Vector:
    """Return a speed factor in [0, 1] per frame: steady, or braking and standing, or standing and setting off."""
    t = np.linspace(0.0, 1.0, frames)
    kind = rng.choice(("walk", "stop", "start"), p=(0.5, 0.3, 0.2))
    if kind == "walk":
        return np.ones(frames)
    edge = rng.uniform(0.35, 0.55)
    ease = np.clip((edge - t) / 0.15, 0.0, 1.0)
    ease = ease * ease * (3.0 - 2.0 * ease)
    return ease if kind == "stop" else ease[::-1]


def _glances(rng: np.random.Generator, travelled: Vector) -> tuple[Vector, Vector]:
    """Return yaw and pitch in radians of a head that looks around while walking: two slow waves and a steady turn."""
    t = travelled / FRAMES_PER_SECOND
    yaw = rng.uniform(-0.5, 0.5) + rng.uniform(-0.4, 0.4) * t
    pitch = rng.uniform(-0.12, 0.08) + np.zeros_like(t)
    for frequency in rng.uniform(0.3, 1.2, size=2):
        phase = rng.uniform(0.0, 2.0 * np.pi, size=2)
        yaw = yaw + rng.uniform(0.01, 0.07) * np.sin(2.0 * np.pi * frequency * t + phase[0])
        pitch = pitch + rng.uniform(0.005, 0.02) * np.sin(2.0 * np.pi * frequency * t + phase[1])
    return yaw, pitch


def _rotated(forward: Vector, yaw: Vector, pitch: Vector) -> Vector:
    c, s = np.cos(yaw), np.sin(yaw)
    x, y, z = forward.T
    rotated = np.stack((c * x + s * z, y, -s * x + c * z), axis=1)
    rotated[:, 1] += np.tan(pitch) * np.hypot(rotated[:, 0], rotated[:, 2])
    return rotated


def _distance(pace: Vector) -> Vector:
    """Return the distance before each frame, in frames of full pace; ``pace[k]`` is for the step from frame k."""
    return np.concatenate(([0.0], np.cumsum(pace)[:-1]))


def walk(route: Route, rng: np.random.Generator, frames: int) -> Poses:
    """Walk and look around: steadily, or braking to a stop, or setting off; a standing camera is exactly still."""
    points = np.asarray(route.points, dtype=np.float64)
    length = route_length(points)
    # Walking pace on a short route, a slow drive on a long one.
    speed = rng.uniform(0.5, 1.0) * np.clip(length / 6.0, 1.0, 6.0)
    travelled = _distance(_pace(rng, frames))
    walked = speed * travelled / FRAMES_PER_SECOND
    start = rng.uniform(0.0, max(length - walked[-1], 0.0))
    distance = np.clip(start + walked, 0.0, length)
    if rng.random() < 0.5 and route.focus is None:
        distance = distance[::-1].copy()
    eye = along(points, distance)
    forward = heading(route, points, distance, eye)
    forward[np.hypot(forward[:, 0], forward[:, 2]) < 1e-6, 2] = -1.0  # a point or a vertical route has no heading
    yaw, pitch = _glances(rng, travelled)
    return Poses(eye, _rotated(forward, yaw, pitch), np.zeros(frames))


def _facing(rail: Rail, rng: np.random.Generator) -> float:
    """Return a random initial yaw relative to the heading: within 0.5 radians, or any if the route has no heading."""
    return rng.uniform(-np.pi, np.pi) if rail.aimless else rng.uniform(-0.5, 0.5)


def stops(route: Route, rng: np.random.Generator, frames: int) -> Poses:
    """Travel steadily with repeated full stops of 10 frames (QRISP, annex A.3).

    The paper gives the 10 frames and says that not every segment has a stop. Our own choice: 6 frames of braking and of
    setting off, 20 to 60 frames from stop to stop, and a first stop early enough to fit within 30 frames.
    """
    rail = Rail.sample(route, rng)
    pace = np.ones(frames + 2 * _RAMP + STOP)
    ramp = np.linspace(0.0, 1.0, _RAMP + 2)[1:-1]
    ramp = ramp * ramp * (3.0 - 2.0 * ramp)
    stop = np.concatenate((ramp[::-1], np.zeros(STOP - 1), ramp))
    begin = int(rng.integers(1, 30 - STOP))
    while begin < frames:
        pace[begin : begin + len(stop)] = stop  # shifted by the ramp, so that a stop may begin before the clip
        begin += STOP + int(rng.integers(20, 61))
    travelled = _distance(pace[_RAMP : _RAMP + frames])
    speed = rng.uniform(0.75, 1.5) * np.clip(rail.length / 6.0, 1.0, 6.0)
    eye, yaw, pitch = rail.poses(rail.ride(rng, speed, travelled))
    aside, up = _glances(rng, travelled)
    return Poses(eye, directions(yaw + _facing(rail, rng) + aside, pitch + up), np.zeros(frames))


def fast(route: Route, rng: np.random.Generator, frames: int) -> Poses:
    """Travel and turn fast: NSRD's "fast-moving cameras" (section 4.1), whose speeds the paper does not give.

    Our own choice: 3 to 6 m/s (more on routes over 6 m, less if the clip would leave the route), a steady turn of 20 to
    60 degrees per second, and a swing of 5 to 15 degrees to either side.
    """
    rail = Rail.sample(route, rng)
    travelled = np.arange(frames, dtype=np.float64)
    speed = rng.uniform(3.0, 6.0) * np.clip(rail.length / 6.0, 1.0, 6.0)
    eye, yaw, pitch = rail.poses(rail.ride(rng, speed, travelled))
    t = travelled / FRAMES_PER_SECOND
    turn = np.radians(rng.uniform(20.0, 60.0)) * rng.choice((-1.0, 1.0))
    swing = np.radians(rng.uniform(5.0, 15.0))
    nod = np.radians(rng.uniform(1.0, 4.0))
    phase = rng.uniform(0.0, 2.0 * np.pi, size=2)
    frequency = 2.0 * np.pi * rng.uniform(0.4, 0.9, size=2)
    # The turn passes the heading in the middle of the clip, so that a short clip also shows what the route looks at.
    yaw = yaw + _facing(rail, rng) + turn * (t - t.mean()) + swing * np.sin(frequency[0] * t + phase[0])
    pitch = pitch + rng.uniform(-0.12, 0.08) + nod * np.sin(frequency[1] * t + phase[1])
    return Poses(eye, directions(yaw, pitch), np.zeros(frames))


def still(route: Route, rng: np.random.Generator, frames: int) -> Poses:
    """Stand exactly still for the whole clip, anywhere on the route; the scene itself keeps moving."""
    rail = Rail.sample(route, rng)
    eye, yaw, pitch = rail.poses(np.full(frames, rng.uniform(0.0, rail.length)))
    yaw, pitch = yaw + _facing(rail, rng), pitch + rng.uniform(-0.12, 0.08)
    return Poses(eye, directions(yaw, pitch), np.zeros(frames))


_PLAIN: dict[str, CameraStyle] = {"walk": walk, "head": head, "stops": stops, "fast": fast, "still": still}


def mixed(route: Route, rng: np.random.Generator, frames: int) -> Poses:
    """Use one of the other styles, drawn for each clip."""
    styles = list(_PLAIN.values())
    return styles[int(rng.integers(len(styles)))](route, rng, frames)


_STYLES: dict[str, CameraStyle] = {**_PLAIN, "mixed": mixed}


def camera_style(name: str) -> CameraStyle:
    """Return the style called ``name``.

    Raises:
        UserError: The name is unknown.
    """
    if name not in _STYLES:
        raise UserError(f"Invalid data.camera={name}: use {', '.join(_STYLES)}.")
    return _STYLES[name]
