"""Cost of each buffer when only it is rendered: seconds and stored bytes per frame."""

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

import h5py
import numpy as np

from supersampling.data.writer import ClipWriter
from supersampling.frames import BUFFERS
from supersampling.render.camera import Shot, Window
from supersampling.render.jitter import mip_bias
from supersampling.render.measure.probe import FRAME, seeded_shots
from supersampling.render.renderer import Image, Renderer
from supersampling.scenes.scene import Scene

SCALE, SAMPLES, SIDE = 4, 4, 256  # a window of 256 x 256 target pixels
FRAMES = 5


@dataclass(frozen=True)
class BufferCost:
    """Cost per frame of one buffer: median rendering seconds, bytes as stored in a data set, uncompressed bytes."""

    name: str
    seconds: float
    stored: float
    raw: float


def costs(scene: Scene) -> list[BufferCost]:
    """Measure every rendered buffer of `frames.BUFFERS` over a few moments of the scene, each after a warm-up."""
    x, y = (FRAME[0] - SIDE) // 2, (FRAME[1] - SIDE) // 2
    window = Window(*FRAME, x, y, SIDE, SIDE)
    shots = [replace(shot, window=window) for shot in seeded_shots(scene, FRAMES)]
    with Renderer(scene) as renderer, tempfile.TemporaryDirectory() as folder:
        return [_cost(renderer, shots, name, Path(folder)) for name in BUFFERS if name != "jitter"]


def _render(renderer: Renderer, shot: Shot, name: str) -> Image:
    if BUFFERS[name].resolution == "low":
        jitter = (0.25, -0.25)
        return renderer.low(shot, SCALE, jitter, mip_bias("matched", SCALE), frozenset({name}))[name]
    return renderer.high(shot, SAMPLES, 0.0, frozenset({name}))[name]


def _cost(renderer: Renderer, shots: list[Shot], name: str, folder: Path) -> BufferCost:
    path = folder / f"{name}.h5"
    seconds = []
    _render(renderer, shots[0], name)
    with ClipWriter(path, {name: len(shots)}) as writer:
        for shot in shots:
            began = time.perf_counter()
            image = _render(renderer, shot, name)
            seconds.append(time.perf_counter() - began)
            writer.add(name, image)
    with h5py.File(path, "r") as file:
        stored = file[name].id.get_storage_size() / len(shots)
        raw = float(np.prod(file[name].shape[1:])) * file[name].dtype.itemsize
    return BufferCost(name, median(seconds), stored, raw)


def table(buffers: list[BufferCost]) -> str:
    """Return the costs as a Markdown table."""
    head = "| buffer | stored as | seconds per frame | kB per frame | share of raw size |\n|---|---|---|---|---|\n"
    rows = (
        f"| `{c.name}` | {BUFFERS[c.name].channels} x {BUFFERS[c.name].dtype} | {c.seconds:.3f} | {c.stored / 1e3:.1f} "
        f"| {c.stored / c.raw:.0%} |"
        for c in buffers
    )
    return head + "\n".join(rows)
