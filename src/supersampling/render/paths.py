"""Seeded camera paths along a scene's routes, and the assignment of routes to splits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from supersampling.render.camera import Camera
from supersampling.render.rail import FRAMES_PER_SECOND as FRAMES_PER_SECOND
from supersampling.render.styles import camera_style
from supersampling.scenes.scene import Route, Scene, look_at

# Routes are assigned to splits in this repeating order, so that no two splits share a route.
_SPLIT_OF_ROUTE = ("train", "test", "train", "val", "train", "test")


@dataclass(frozen=True, eq=False)
class CameraPath:
    """One camera per frame, and the scene's clock at each frame in seconds."""

    cameras: tuple[Camera, ...]
    seconds: tuple[float, ...]


def rolled(view: NDArray[np.float64], roll: float) -> NDArray[np.float64]:
    """Return the view of a camera that is turned clockwise about its viewing direction by ``roll`` radians."""
    c, s = np.cos(roll), np.sin(roll)
    turn = np.eye(4)
    turn[:2, :2] = ((c, -s), (s, c))
    return turn @ view


def split_routes(scene: Scene, split: str) -> list[Route]:
    """Return the routes of a split; scenes have at least six routes, so no split is empty."""
    return [r for k, r in enumerate(scene.routes) if _SPLIT_OF_ROUTE[k % len(_SPLIT_OF_ROUTE)] == split]


def camera_path(route: Route, rng: np.random.Generator, frames: int, style: str = "walk") -> CameraPath:
    """Return the path of a camera that moves along ``route`` in a style of `supersampling.render.styles`.

    The scene's clock starts at a random moment in [0, 60) s. A route with a recorded camera follows the recording from
    that moment, whatever the style.

    Raises:
        UserError: The style does not exist.
    """
    move = camera_style(style)
    if route.recorded is not None:
        seconds = _clock(rng, frames)
        views = [_view_matrix(route.recorded(t)) for t in seconds]
    else:
        poses = move(route, rng, frames)
        views = [rolled(look_at(e, f), r) for e, f, r in zip(poses.eye, poses.forward, poses.roll)]
        seconds = _clock(rng, frames)
    return CameraPath(tuple(Camera(view, route.fov) for view in views), seconds)


def _clock(rng: np.random.Generator, frames: int) -> tuple[float, ...]:
    first = rng.uniform(0.0, 60.0)
    return tuple(first + k / FRAMES_PER_SECOND for k in range(frames))


def _view_matrix(camera: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the world-to-camera matrix of a camera-to-world matrix, whose scale (from a scene file) is ignored."""
    axes = camera[:3, :3].astype(np.float64)
    axes = axes / np.linalg.norm(axes, axis=0)
    view = np.eye(4)
    view[:3, :3] = axes.T
    view[:3, 3] = -axes.T @ camera[:3, 3]
    return view
