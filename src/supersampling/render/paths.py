"""Seeded camera paths along a scene's routes, and which routes belong to which split."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Camera
from supersampling.render.rail import FRAMES_PER_SECOND as FRAMES_PER_SECOND
from supersampling.render.styles import camera_style
from supersampling.scenes.scene import Route, Scene, look_at

# Routes go to the splits in this order, again and again, so that no two splits share a path.
_SPLIT_OF_ROUTE = ("train", "test", "train", "val", "train", "test")


@dataclass(frozen=True, eq=False)
class CameraPath:
    """One camera a frame, and the scene's clock at each frame in seconds."""

    cameras: tuple[Camera, ...]
    seconds: tuple[float, ...]


def rolled(view: NDArray[np.float64], roll: float) -> NDArray[np.float64]:
    """The view of a camera that has turned clockwise about its viewing direction by ``roll`` radians."""
    c, s = np.cos(roll), np.sin(roll)
    turn = np.eye(4)
    turn[:2, :2] = ((c, -s), (s, c))
    return turn @ view


def routes_of(scene: Scene, split: str) -> list[Route]:
    """The routes that belong to a split; scenes have at least six routes, so none is empty."""
    return [r for k, r in enumerate(scene.routes) if _SPLIT_OF_ROUTE[k % len(_SPLIT_OF_ROUTE)] == split]


def camera_path(route: Route, rng: np.random.Generator, frames: int, style: str = "walk") -> CameraPath:
    """A camera that moves on ``route`` in a style of `supersampling.render.styles`, from a random moment in [0, 60) s on.

    A route with a recorded camera follows that one from the random moment, whatever the style.

    Raises:
        UserError: there is no such style.
    """
    move = camera_style(style)
    if route.recorded is not None:
        seconds = _clock(rng, frames)
        views = [_view_of(route.recorded(t)) for t in seconds]
    else:
        poses = move(route, rng, frames)
        views = [rolled(look_at(e, f), r) for e, f, r in zip(poses.eye, poses.forward, poses.roll)]
        seconds = _clock(rng, frames)
    return CameraPath(tuple(Camera(view, route.fov) for view in views), seconds)


def _clock(rng: np.random.Generator, frames: int) -> tuple[float, ...]:
    first = rng.uniform(0.0, 60.0)
    return tuple(first + k / FRAMES_PER_SECOND for k in range(frames))


def _view_of(camera: NDArray[np.float32]) -> NDArray[np.float64]:
    """World-to-camera matrix of a camera-to-world one, whose scale (a scene file may have one) does not count."""
    axes = camera[:3, :3].astype(np.float64)
    axes = axes / np.linalg.norm(axes, axis=0)
    view = np.eye(4)
    view[:3, :3] = axes.T
    view[:3, 3] = -axes.T @ camera[:3, 3]
    return view
