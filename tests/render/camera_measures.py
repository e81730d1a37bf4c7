"""Test routes for cameras, and measures of camera paths."""

from itertools import groupby, pairwise

import numpy as np

from supersampling.render.paths import CameraPath, camera_path
from supersampling.scenes.scene import Route

STYLES = ("walk", "head", "stops", "fast", "still", "mixed")
BENT = [(0, 1.6, 0), (0, 1.6, -6), (3, 1.6, -9)]
ROUTE = Route("line", np.array(BENT, dtype=np.float32))


def route(name: str, points: list, focus: list | None = None, fov: float = 1.05) -> Route:
    target = None if focus is None else np.array(focus, dtype=np.float32)
    return Route(name, np.array(points, dtype=np.float32), target, fov=fov)


ROUTES = (
    route("bent", BENT),
    route("focus", BENT, [(8, 1, -3), (8, 2, -8)], fov=0.7),
    route("long", [(20 * np.cos(a), 1.5, 20 * np.sin(a)) for a in np.linspace(0, 6, 40)]),
    route("point", [(1, 2, 3)]),
    route("point and focus", [(1, 2, 3)], [(4, 2, 3), (6, 2, 5)]),
    route("no length", [(1, 2, 3), (1, 2, 3)]),
    route("straight up", [(0, 1, 0), (0, 4, 0)]),
    route("over its focus", [(0, 5, 3), (0, 5, -3)], [(0, 0, 0)]),
)


def path(style: str, seed: int = 0, frames: int = 60, on: Route = ROUTE) -> CameraPath:
    return camera_path(on, np.random.default_rng(seed), frames, style)


def eyes(p: CameraPath) -> np.ndarray:
    return np.stack([-c.view[:3, :3].T @ c.view[:3, 3] for c in p.cameras])


def spins(p: CameraPath) -> np.ndarray:
    """Return angular velocities ``(T - 1, 3)`` in degrees per second, from the skew part of rotations."""
    turns = [b.view[:3, :3] @ a.view[:3, :3].T for a, b in pairwise(p.cameras)]
    skew = [(r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]) for r in turns]
    return np.degrees(np.array(skew) / 2).reshape(-1, 3) * 60


def speeds(p: CameraPath) -> np.ndarray:
    """Return angular speeds ``(T - 1,)`` in degrees per second."""
    return np.linalg.norm(spins(p), axis=1)


def stands(p: CameraPath) -> list[bool]:
    """Return for each frame except the first whether its view equals the previous one."""
    return [bool((a.view == b.view).all()) for a, b in pairwise(p.cameras)]


def stop_lengths(p: CameraPath) -> list[int]:
    """Return the frames of each stop, without a stop that the end of the clip cuts short."""
    runs = [(same, len(list(run))) for same, run in groupby(stands(p))]
    whole = runs[:-1] if runs[-1][0] else runs
    return [n + 1 for same, n in whole if same]
