"""Seeded camera paths along a scene's routes: walking, turning, and standing still for a while."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Camera
from supersampling.render.scene import Route, Scene

Vector = NDArray[np.float64]
FRAMES_PER_SECOND = 60.0  # what the thesis aims at (4.3.4)

# Routes go to the splits in this order, again and again, so that no two splits share a path.
_SPLIT_OF_ROUTE = ("train", "test", "train", "val", "train", "test")


@dataclass(frozen=True, eq=False)
class CameraPath:
    """One camera a frame, and the scene's clock at each frame in seconds."""

    cameras: tuple[Camera, ...]
    seconds: tuple[float, ...]


def look_at(eye: Vector, forward: Vector) -> NDArray[np.float64]:
    """World-to-camera matrix of a camera at ``eye`` that looks along ``forward`` (not vertical), y up."""
    back = -forward / np.linalg.norm(forward)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    view = np.eye(4)
    view[:3, :3] = np.stack((right, up, back))
    view[:3, 3] = -view[:3, :3] @ eye
    return view


def routes_of(scene: Scene, split: str) -> list[Route]:
    """The routes that belong to a split; scenes have at least six routes, so none is empty."""
    return [r for k, r in enumerate(scene.routes) if _SPLIT_OF_ROUTE[k % len(_SPLIT_OF_ROUTE)] == split]


def _along(points: Vector, distance: Vector) -> Vector:
    """Positions at arc lengths ``distance`` of a polyline, its corners rounded by averaging over a short stretch."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(steps)))
    radius = 0.08 * arc[-1]
    offsets = np.linspace(-radius, radius, 9)
    at = np.clip(distance[:, None] + offsets, 0.0, arc[-1])
    return np.stack([np.interp(at, arc, points[:, k]).mean(axis=1) for k in range(3)], axis=1)


def _pace(rng: np.random.Generator, frames: int) -> Vector:
    """Speed factor in [0, 1] of each frame: steady, or coming to a stop and standing, or standing and setting off."""
    t = np.linspace(0.0, 1.0, frames)
    kind = rng.choice(("walk", "stop", "start"), p=(0.5, 0.3, 0.2))
    if kind == "walk":
        return np.ones(frames)
    edge = rng.uniform(0.35, 0.55)
    ease = np.clip((edge - t) / 0.15, 0.0, 1.0)
    ease = ease * ease * (3.0 - 2.0 * ease)
    return ease if kind == "stop" else ease[::-1]


def camera_path(route: Route, rng: np.random.Generator, frames: int) -> CameraPath:
    """A camera on ``route``: a random start, speed and pace, looking ahead or at the route's focus, and turning.

    The head turns with the pace, so that a camera that stands is exactly still; the scene's own motion goes on.
    """
    points = np.asarray(route.points, dtype=np.float64)
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    # Walking pace on a short route, a slow drive on a long one.
    speed = rng.uniform(0.5, 1.0) * np.clip(length / 6.0, 1.0, 6.0)
    pace = _pace(rng, frames)
    travelled = np.concatenate(([0.0], np.cumsum(pace)[:-1]))
    walked = speed * travelled / FRAMES_PER_SECOND
    start = rng.uniform(0.0, max(length - walked[-1], 0.0))
    distance = np.clip(start + walked, 0.0, length)
    if rng.random() < 0.5 and route.focus is None:
        distance = distance[::-1].copy()
    eye = _along(points, distance)
    forward = _heading(route, points, distance, length, eye)
    yaw, pitch = _head(rng, travelled)
    cameras = []
    for k in range(frames):
        cameras.append(Camera(view=look_at(eye[k], _turned(forward[k], yaw[k], pitch[k])), fov=1.05))
    first = rng.uniform(0.0, 60.0)
    return CameraPath(tuple(cameras), tuple(first + k / FRAMES_PER_SECOND for k in range(frames)))


def _heading(route: Route, points: Vector, distance: Vector, length: float, eye: Vector) -> Vector:
    """Unit viewing directions, never vertical: towards the focus, else along the route."""
    if route.focus is not None:
        focus = np.asarray(route.focus, dtype=np.float64)
        reach = float(np.linalg.norm(np.diff(focus, axis=0), axis=1).sum())
        forward = _along(focus, distance * (reach / max(length, 1e-9))) - eye
    else:
        reach = 0.15 * length
        forward = _along(points, np.minimum(distance + reach, length)) - _along(
            points, np.maximum(distance - reach, 0.0)
        )
    forward = forward / np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    forward[:, 1] = np.clip(forward[:, 1], -0.6, 0.6)
    return forward


def _head(rng: np.random.Generator, travelled: Vector) -> tuple[Vector, Vector]:
    """Yaw and pitch in radians of a head that looks about while it walks: two slow waves and a steady turn."""
    t = travelled / FRAMES_PER_SECOND
    yaw = rng.uniform(-0.5, 0.5) + rng.uniform(-0.4, 0.4) * t
    pitch = rng.uniform(-0.12, 0.08) + np.zeros_like(t)
    for frequency in rng.uniform(0.3, 1.2, size=2):
        phase = rng.uniform(0.0, 2.0 * np.pi, size=2)
        yaw = yaw + rng.uniform(0.01, 0.07) * np.sin(2.0 * np.pi * frequency * t + phase[0])
        pitch = pitch + rng.uniform(0.005, 0.02) * np.sin(2.0 * np.pi * frequency * t + phase[1])
    return yaw, pitch


def _turned(forward: Vector, yaw: float, pitch: float) -> Vector:
    c, s = np.cos(yaw), np.sin(yaw)
    x, y, z = forward
    turned = np.array((c * x + s * z, y, -s * x + c * z))
    turned[1] += np.tan(pitch) * np.hypot(turned[0], turned[2])
    return turned
