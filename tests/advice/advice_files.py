"""Data set files with chosen buffers."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, join_clips
from supersampling.frames import BUFFERS

SCALE = 4


def write_file(
    folder: Path, split: str, clips: list[Mapping[str, NDArray[np.float32]]], scene: str = "synthetic"
) -> Path:
    """Write a file of clips and return its path.

    Buffers are ``(T, h, w, C)``; those of high resolution are 4 times as high and wide.
    """
    names = list(clips[0])
    frames, height, width = next(c.shape[:3] for n, c in clips[0].items() if BUFFERS[n].resolution == "low")
    size = (width * SCALE, height * SCALE)
    spec = CaptureSpec(
        scene=scene,
        split=split,
        clips=len(clips),
        frames=frames,
        targets=frames,
        frame=size,
        window=size,
        scale=SCALE,
        jitter="thesis",
        mip_bias="matched",
        samples=1,
        seed=0,
        candidates=1,
    )
    path = folder / spec.file_name
    parts = [folder / f"{split}{k}.clip" for k in range(len(clips))]
    for part, clip in zip(parts, clips):
        with ClipWriter(part, dict.fromkeys(clip, frames)) as writer:
            for name, values in clip.items():
                for image in values:
                    writer.add(name, image)
    join_clips(path, spec, parts, frozenset(names), {"renderer": "synthetic"})
    for part in parts:
        part.unlink()
    return path
