"""Selection of each clip's window and moment by content, so that clips have detail, motion and disocclusion."""

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from supersampling.data.pick import motion_edges
from supersampling.data.spec import CaptureSpec
from supersampling.render.camera import Shot, Window
from supersampling.render.paths import CameraPath, camera_path, split_routes
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Scene


@dataclass(frozen=True, eq=False)
class Take:
    """Clip before it is rendered: camera path, window, and start in the jitter sequence."""

    path: CameraPath
    window: Window
    jitter_phase: int

    def shot(self, frame: int) -> Shot:
        previous = max(frame - 1, 0)
        cameras, seconds = self.path.cameras, self.path.seconds
        return Shot(cameras[frame], cameras[previous], seconds[frame], seconds[previous], self.window)


def propose(scene: Scene, spec: CaptureSpec, rng: np.random.Generator) -> Take:
    """Return a random take on one of the split's routes, with the window anywhere in the frame."""
    routes = split_routes(scene, spec.split)
    path = camera_path(routes[rng.integers(len(routes))], rng, spec.frames, spec.camera)
    width, height = spec.target_size
    x = int(rng.integers(0, spec.frame[0] - width + 1))
    y = int(rng.integers(0, spec.frame[1] - height + 1))
    return Take(path, Window(spec.frame[0], spec.frame[1], x, y, width, height), int(rng.integers(1 << 16)))


def interest(low: dict[str, NDArray[np.float32]], scale: int) -> float:
    """Return the score of a low-resolution frame in [0, 1] by its detail, motion and motion edges (disocclusions).

    Detail is the mean absolute difference of neighbouring pixels and saturates at 0.1; motion edges saturate at 6% of
    the pixels. Speeds above 16 target pixels per frame and edges in over 30% of the pixels (a mesh fence that fills the
    window) lower the score, because the history is useless there.
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


def select_take(renderer: Renderer, spec: CaptureSpec, clip: int) -> Take:
    """Return the best of the clip's ``spec.candidates`` seeded takes; it does not depend on buffers or sample count."""
    takes = _proposals(renderer.scene, spec, clip)
    return takes[0] if len(takes) == 1 else _best(renderer, spec, takes)


def _proposals(scene: Scene, spec: CaptureSpec, clip: int) -> list[Take]:
    rng = np.random.default_rng((spec.seed, crc32(f"{spec.scene}/{spec.split}".encode()), clip))
    return [propose(scene, spec, rng) for _ in range(max(spec.candidates, 1))]


def _best(renderer: Renderer, spec: CaptureSpec, takes: list[Take]) -> Take:
    scores = []
    for take in takes:
        # Score at a quarter of the window's resolution, at two moments: one has motion even if the camera stops or
        # starts.
        width, height = take.window.width // 4 * 4, take.window.height // 4 * 4
        window = Window(*spec.frame, take.window.x, take.window.y, width, height)
        interests = []
        for moment in (spec.frames // 4, 3 * spec.frames // 4):
            shot = replace(take.shot(min(max(moment, 1), spec.frames - 1)), window=window)
            interests.append(interest(renderer.preview(shot, 4), 4))
        scores.append(float(np.mean(interests)))
    return takes[int(np.argmax(scores))]
