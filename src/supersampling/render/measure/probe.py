"""Scene under measurement: seeded shots of its routes, object ids that distinguish meshes, and positions in float64.

No motion vectors are read: a point's previous position comes from its depth, the cameras and the objects' transforms.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from types import TracebackType
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from supersampling.render import matrices
from supersampling.render.camera import Matrix, Shot, Window
from supersampling.render.gpu_scene import in_world
from supersampling.render.paths import camera_path, split_routes
from supersampling.render.renderer import Image, Renderer
from supersampling.scenes.scene import Object, Scene

FRAME = (1920, 1080)  # the target's frame
_FRAMES, _MOMENT = 24, 8  # a shot is frame 8 of a path of 24: a walk that stops has not stopped yet

Ids = NDArray[np.intp]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Points:
    """Previous positions of the surface under each pixel.

    ``uv (h, w, 2)`` is in the previous frame's window, between 0 and 1 inside it; ``inverse (h, w)`` is the inverse of
    the previous view depth in 1/m, 0 for the sky and negative behind the camera.
    """

    uv: Matrix
    inverse: Matrix


def by_mesh(scene: Scene) -> tuple[Scene, Ids]:
    """Return the scene with one object per mesh, and the original object id of each new one (the sky's 0 stays).

    Elements of the interface are left out: they have neither depth nor motion.
    """
    owners = [
        (k, m)
        for k, item in enumerate(scene.objects)
        for m in item.meshes
        if not scene.materials[scene.meshes[m].material].interface
    ]
    objects = [replace(scene.objects[k], meshes=(m,)) for k, m in owners]
    return replace(scene, objects=objects), np.array([0, *(k + 1 for k, _ in owners)])


def interface_drawn(scene: Scene) -> Scene:
    """Return the scene with its interface as ordinary surfaces, so that object ids show it."""
    return replace(scene, materials=[replace(m, interface=False) for m in scene.materials])


def seeded_shots(scene: Scene, count: int) -> list[Shot]:
    """Return ``count`` shots of whole frames, alternately of test and training routes, each route in turn."""
    rng = np.random.default_rng(crc32(scene.name.encode()))
    order = {split: rng.permutation(len(split_routes(scene, split))) for split in ("test", "train")}
    shots = []
    for k in range(count):
        split = ("test", "train")[k % 2]
        routes = split_routes(scene, split)
        route = routes[order[split][(k // 2) % len(routes)]]
        path = camera_path(route, rng, _FRAMES)
        a, b = _MOMENT, _MOMENT - 1
        shots.append(Shot(path.cameras[a], path.cameras[b], path.seconds[a], path.seconds[b], whole(1)))
    return shots


def standing(scene: Scene, paths: int = 60, frames: int = 60) -> tuple[float, float]:
    """Return the shares of paths whose camera never moves and of frames whose camera has not moved, over all routes."""
    rng = np.random.default_rng(0)
    still = np.empty((paths, frames - 1), dtype=bool)
    for k in range(paths):
        cameras = camera_path(scene.routes[k % len(scene.routes)], rng, frames).cameras
        still[k] = [np.array_equal(a.view, b.view) for a, b in pairwise(cameras)]
    return float(still.all(axis=1).mean()), float(still.mean())


def whole(samples: int) -> Window:
    """Return the window of a whole 1080p frame with ``samples`` x ``samples`` per pixel."""
    width, height = FRAME[0] * samples, FRAME[1] * samples
    return Window(width, height, 0, 0, width, height)


def around(x: float, y: float, side: int, samples: int) -> Window:
    """Return a square window of ``side`` samples around ``x, y`` (in [0, 1]), moved to lie inside the frame."""
    width, height = FRAME[0] * samples, FRAME[1] * samples
    left = int(np.clip(x * width - side / 2, 0, width - side))
    top = int(np.clip(y * height - side / 2, 0, height - side))
    return Window(width, height, left, top, side, side)


def backwards(shot: Shot) -> Shot:
    """Return the shot of the previous instant, which is also its own previous instant."""
    return Shot(shot.previous_camera, shot.previous_camera, shot.previous_seconds, shot.previous_seconds, shot.window)


class Probe:
    """Renderer of a scene under measurement, a context manager.

    For each object id of its renders, ``owner`` is the scene's original object id, ``moves`` whether it moves, and
    ``tested`` whether its material is alpha-tested; entry 0 is the sky.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.owner = by_mesh(scene)
        self.renderer = Renderer(self.scene)
        objects = self.scene.objects
        self.moves: Mask = np.array([False, *(o.moves for o in objects)])
        materials = [scene.materials[scene.meshes[o.meshes[0]].material] for o in objects]
        self.tested: Mask = np.array([False, *(m.alpha != "opaque" for m in materials)])

    def samples(self, shot: Shot, mip_bias: float, *names: str) -> dict[str, Image]:
        """Render one sample at the centre of each pixel of the shot's window."""
        return self.renderer.low(shot, 1, (0.0, 0.0), mip_bias, frozenset(names))

    def inverse_depth(self, depth: Image) -> Matrix:
        """Return the inverse view depth ``(h, w)`` in 1/m, 0 for the sky."""
        near, far = self.scene.near, self.scene.far
        metres = near + (far - near) * depth[..., 0].astype(np.float64)
        return np.where(depth[..., 0] < 1.0, 1.0 / metres, 0.0)

    def previous(self, shot: Shot, size: tuple[int, int], inverse: Matrix, ids: Ids) -> Points:
        """Return previous positions of pixels from inverse depths and object ids ``(h, w)``; ``size`` is ``(w, h)``."""
        rays, eye = _rays(shot, size), matrices.eye_position(shot.camera.view)
        sky = inverse == 0.0
        # The sky is a direction: a point at infinity, whose last homogeneous coordinate is 0.
        points = np.where(sky[..., None], rays, eye + rays / np.where(sky, 1.0, inverse)[..., None])
        for k in np.unique(ids[self.moves[ids]]):
            mask = ids == k
            back = _step_back(self.scene.objects[k - 1], shot)
            points[mask] = points[mask] @ back[:3, :3].T + back[:3, 3]
        view = shot.previous_camera.view
        seen = points @ view[:3, :3].T + np.where(sky[..., None], 0.0, view[:3, 3])
        near, far = self.scene.near, self.scene.far
        to_clip = matrices.window_projection(shot.previous_camera, shot.window, near, far)
        ahead = -seen[..., 2]
        safe = np.where(np.abs(ahead) < 1e-9, 1e-9, ahead)  # points in the camera's plane are far outside the image
        uv = (seen @ to_clip[:2, :3].T / safe[..., None]) / 2.0 + 0.5
        return Points(uv, np.where(sky, 0.0, 1.0 / safe))

    def __enter__(self) -> "Probe":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.renderer.close()


def _rays(shot: Shot, size: tuple[int, int]) -> Matrix:
    """Return world rays ``(h, w, 3)`` of unit view depth through the pixels' centres."""
    width, height = size
    # Rays do not depend on the near and far planes.
    projection = matrices.window_projection(shot.camera, shot.window, 1.0, 2.0)
    basis = matrices.ray_basis(shot.camera.view, projection)
    y, x = np.mgrid[0:height, 0:width] + 0.5
    ndc = np.stack((2.0 * x / width - 1.0, 2.0 * y / height - 1.0, np.ones_like(x)), axis=-1)
    return np.asarray(ndc @ basis.T, np.float64)


def _step_back(item: Object, shot: Shot) -> Matrix:
    """Return the ``(4, 4)`` matrix from current to previous world positions of a moving object's points."""
    now = in_world(item, shot.seconds, shot.camera.view)
    before = in_world(item, shot.previous_seconds, shot.previous_camera.view)
    return np.asarray(before @ np.linalg.inv(now), np.float64)


def shifted(values: NDArray, reach: int = 1) -> Iterator[tuple[NDArray, NDArray]]:
    """Yield ``values (h, w)`` shifted by ``reach`` pixels to the left and right, then up and down; edges repeat."""
    for axis in (1, 0):
        wide = np.pad(values, [(reach, reach) if k == axis else (0, 0) for k in range(values.ndim)], mode="edge")
        length = values.shape[axis]
        yield wide.take(range(length), axis), wide.take(range(2 * reach, 2 * reach + length), axis)
