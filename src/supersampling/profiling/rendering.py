"""Time of the project's renderer for the buffers that methods read, so that a whole frame's time is known."""

import math
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from hydra.utils import instantiate

from supersampling.frames import BUFFERS
from supersampling.models.base import Upsampler
from supersampling.profiling.stream import spread
from supersampling.render.camera import Camera, Shot, Window
from supersampling.render.jitter import jitter_sequence, mip_bias
from supersampling.render.paths import camera_path, split_routes
from supersampling.render.renderer import Renderer
from supersampling.runs.subjects import Subject
from supersampling.scenes.scene import Scene

RENDER = "render"
"""All buffers of a frame. ``render.g_buffers`` are the low-resolution ones without light, ``render.high`` those at the
target's resolution."""
FULL = ""
"""``architecture`` of a frame that is rendered at the target's resolution and shown as it is."""
_LIT = frozenset({"color", "radiance"})
_LEAST = 3  # frames


@dataclass(frozen=True, kw_only=True)
class Request:
    """Buffers of one frame at a target size; ``low`` ones are rendered at 1 / ``scale`` with one sample per pixel.

    ``high`` ones have one sample per target pixel.
    """

    size: tuple[int, int]
    scale: int
    jitter: str
    low: frozenset[str]
    high: frozenset[str]

    def render(self, renderer: Renderer, shot: Shot, frame: int) -> None:
        if self.low:
            sequence = jitter_sequence(self.jitter, self.scale)
            x, y = (float(value) for value in sequence[frame % len(sequence)])
            renderer.low(shot, self.scale, (x, y), mip_bias("matched", self.scale), self.low)
        if self.high:
            renderer.high(shot, 1, 0.0, self.high)


def requests_of(subject: Subject, size: tuple[int, int]) -> dict[str, Request]:
    """Return what to render for a method, by part."""
    model: Upsampler = instantiate(dict(subject.model))
    rendered = frozenset(name for name in model.requires if BUFFERS[name].resolution != "frame")
    low = frozenset(name for name in rendered if BUFFERS[name].resolution == "low")
    none = frozenset[str]()
    parts = {
        RENDER: (low, rendered - low),
        f"{RENDER}.g_buffers": (low - _LIT, none),
        f"{RENDER}.high": (none, rendered - low),
    }
    return {
        part: Request(size=size, scale=subject.scale, jitter=subject.jitter, low=at_low, high=at_high)
        for part, (at_low, at_high) in parts.items()
        if at_low or at_high
    }


def full_frame(size: tuple[int, int]) -> Request:
    """Return the frame in colour at the target's own resolution, with one sample per pixel."""
    return Request(size=size, scale=1, jitter="none", low=frozenset({"color"}), high=frozenset())


def rendering_table(
    scene: Scene, subjects: Sequence[Subject], sizes: Iterable[Sequence[int]], frames: int, seconds: float
) -> pd.DataFrame:
    """Return one row per architecture, target size and part: ``ms`` (median), ``low`` and ``high`` (quartiles).

    Further columns: ``method``, ``scene``, ``frames``, ``buffers``, ``renderer``. The frames of one camera path are
    rendered in turn, each for all requests, so that other load affects all alike: ``frames`` of them, or as many as
    begin within ``seconds`` per request, at least 3. One more frame before them builds what is built once.
    """
    requests = [
        ((subject.name, subject.architecture, part), request)
        for size in sizes
        for subject in subjects
        if not any(side % subject.scale for side in size)
        for part, request in requests_of(subject, (size[0], size[1])).items()
    ]
    requests += [(("", FULL, RENDER), full_frame((size[0], size[1]))) for size in sizes]
    with Renderer(scene) as renderer:
        times = _times(renderer, list(dict.fromkeys(request for _, request in requests)), frames, seconds)
        rows = [_row(key, request, times[request]) for key, request in dict.fromkeys(requests)]
        return pd.DataFrame(rows).assign(scene=scene.name, renderer=renderer.gl_renderer)


def _row(key: tuple[str, str, str], request: Request, seconds: Sequence[float]) -> dict[str, Any]:
    ms = spread([1e3 * value for value in seconds])
    return {
        "method": key[0],
        "architecture": key[1],
        "part": key[2],
        "scale": request.scale,
        "width": request.size[0],
        "height": request.size[1],
        "ms": ms.median,
        "low": ms.low,
        "high": ms.high,
        "frames": ms.count,
        "buffers": ", ".join(sorted(request.low | request.high)),
    }


def _times(renderer: Renderer, requests: Sequence[Request], frames: int, seconds: float) -> dict[Request, list[float]]:
    times: dict[Request, list[float]] = defaultdict(list)
    least, limit = min(_LEAST, frames), seconds * len(requests)
    began = math.inf
    for frame, (instant, earlier) in enumerate(pairwise(_instants(renderer.scene, frames + 2))):
        if frame > least and time.perf_counter() - began > limit:
            break
        for request in requests:
            shot = Shot(instant[0], earlier[0], instant[1], earlier[1], Window(*request.size, 0, 0, *request.size))
            start = time.perf_counter()
            request.render(renderer, shot, frame)
            if frame:
                times[request].append(time.perf_counter() - start)
        began = time.perf_counter() if frame == 0 else began
    return times


def _instants(scene: Scene, count: int) -> Iterator[tuple[Camera, float]]:
    """Yield the camera and the seconds of each instant of a path through the scene."""
    path = camera_path(split_routes(scene, "test")[0], np.random.default_rng(0), count)
    yield from zip(path.cameras, path.seconds)
