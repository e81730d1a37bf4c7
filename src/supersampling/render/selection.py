"""Which part of which moment a clip shows: chosen by content, so that clips hold detail, motion and disocclusion."""

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from supersampling.data.pick import motion_edges
from supersampling.data.spec import CaptureSpec
from supersampling.render.camera import Shot, Window
from supersampling.render.paths import CameraPath, camera_path, routes_of
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Scene


@dataclass(frozen=True, eq=False)
class Take:
    """A clip before it is rendered: the camera's path, the window, and where in the jitter sequence it starts."""

    path: CameraPath
    window: Window
    jitter_phase: int

    def shot(self, frame: int) -> Shot:
        previous = max(frame - 1, 0)
        path = self.path
        return Shot(
            path.cameras[frame],
            path.cameras[previous],
            path.seconds[frame],
            path.seconds[previous],
            self.window,
        )


def propose(scene: Scene, spec: CaptureSpec, rng: np.random.Generator) -> Take:
    """A random take on one of the split's routes, its window anywhere in the frame but its outermost rows."""
    routes = routes_of(scene, spec.split)
    path = camera_path(routes[rng.integers(len(routes))], rng, spec.frames, spec.camera)
    width, height = spec.target_size
    x = int(rng.integers(0, spec.frame[0] - width + 1))
    y = int(rng.integers(0, spec.frame[1] - height + 1))
    return Take(path, Window(spec.frame[0], spec.frame[1], x, y, width, height), int(rng.integers(1 << 16)))


def interest(low: dict[str, NDArray[np.float32]], scale: int) -> float:
    """How much a low-resolution frame has to show, in [0, 1]: fine detail, motion, and motion edges (disocclusions).

    Detail is the mean absolute difference of neighbouring pixels, enough at 0.1; motion edges, enough at 6% of the
    pixels. Speeds beyond 16 target pixels a frame and edges in over 30% of the pixels
    (a mesh fence that fills the window) count ever less: no history is of use there.
    """
    grey = low["color"].mean(axis=2)
    detail = float(np.abs(np.diff(grey, axis=0)).mean() + np.abs(np.diff(grey, axis=1)).mean())
    height, width = grey.shape
    pixels = low["motion"] * np.array((width, height), dtype=np.float32) * scale
    edges = motion_edges(pixels)
    speed = np.linalg.norm(pixels, axis=2)
    moving = float((speed > 0.25).mean())
    calm = 1.0 / (1.0 + (float(speed.mean()) / 16.0) ** 2) / (1.0 + (edges / 0.3) ** 2)
    return calm * min(detail / 0.1, 1.0) * (0.5 + 0.25 * moving + 0.25 * min(edges / 0.06, 1.0))


def choose(renderer: Renderer, spec: CaptureSpec, clip: int) -> Take:
    """The most interesting of the clip's ``spec.candidates`` seeded proposals; the same for every buffer and sample count."""
    takes = _proposals(renderer.scene, spec, clip)
    return takes[0] if len(takes) == 1 else _best(renderer, spec, takes)


def _proposals(scene: Scene, spec: CaptureSpec, clip: int) -> list[Take]:
    rng = np.random.default_rng((spec.seed, crc32(f"{spec.scene}/{spec.split}".encode()), clip))
    return [propose(scene, spec, rng) for _ in range(max(spec.candidates, 1))]


def _best(renderer: Renderer, spec: CaptureSpec, takes: list[Take]) -> Take:
    scores = []
    for take in takes:
        # Judged at a quarter of the window's resolution, at a moment when every pace is still in motion or already is.
        width, height = take.window.width // 4 * 4, take.window.height // 4 * 4
        window = Window(*spec.frame, take.window.x, take.window.y, width, height)
        looks = []
        for moment in (spec.frames // 4, 3 * spec.frames // 4):
            shot = replace(take.shot(min(max(moment, 1), spec.frames - 1)), window=window)
            looks.append(interest(renderer.look(shot, 4), 4))
        scores.append(float(np.mean(looks)))
    return takes[int(np.argmax(scores))]
