"""Data set files of made-up content for the tests of `supersampling.show`."""

from collections.abc import Collection
from pathlib import Path

import numpy as np

from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, join_clips
from supersampling.frames import BUFFERS

SCALE = 4
LOW = (16, 12)  # width, height
FRAMES, TARGETS = 5, 3


def write(folder: Path, names: Collection[str] = tuple(BUFFERS), clips: int = 2, **given: np.ndarray) -> Path:
    """A file of random buffers of the right shapes, ``given`` ones ``(h, w, C)`` the same in every frame instead."""
    width, height = LOW[0] * SCALE, LOW[1] * SCALE
    size = (width, height)
    spec = CaptureSpec(
        scene="made_up",
        split="test",
        clips=clips,
        frames=FRAMES,
        targets=TARGETS,
        frame=size,
        window=size,
        scale=SCALE,
        jitter="thesis",
        mip_bias="matched",
        samples=1,
        seed=0,
        candidates=1,
    )
    rng = np.random.default_rng(0)
    parts = []
    for clip in range(clips):
        parts.append(folder / f"{clip}.clip")
        lengths = {n: TARGETS if BUFFERS[n].resolution == "high" else FRAMES for n in names}
        with ClipWriter(parts[-1], lengths) as writer:
            for name, length in lengths.items():
                b = BUFFERS[name]
                shape = {"low": (*LOW[::-1], b.channels), "high": (height, width, b.channels), "frame": (2,)}[
                    b.resolution
                ]
                for _ in range(length):
                    made = rng.integers(0, 5, shape) if b.kind == "id" else rng.uniform(0.0, 0.4, shape)
                    writer.add(name, given.get(name, made).astype(np.float32))
    path = folder / spec.file_name
    join_clips(path, spec, parts, frozenset(names), {"renderer": "made up", "frames_per_second": "24.0"})
    for part in parts:
        part.unlink()
    return path
