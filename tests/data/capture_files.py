"""A small world in closed form, written as a data set file with every buffer that a capture layout has.

A textured plane slides over the image, a nearer textured square slides over the plane: pixels behind the
square come into view. Positions are target pixels, x right, y down; a surface that slides by ``v`` per frame was at
``p - v`` before.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, join_clips

SIZE = (96, 64)
PLANE, SQUARE = np.array((2.6, 1.7)), np.array((-5.2, 4.1))
JITTER = np.array(((0.25, -0.375), (-0.4375, 0.125), (0.375, 0.4375), (-0.125, -0.25)), dtype=np.float32)
SIDE = 26
ALL = [
    *("color", "radiance", "depth", "motion", "motion_dual", "jitter", "normal", "material", "emission"),
    *("target", "target_radiance", "high_motion", "high_material", "high_emission"),
]

Array = NDArray[np.float64]


def texture(x: Array, y: Array, seed: int) -> Array:
    """``(..., 3)`` in [0.1, 0.9]: plane waves of 5 to 20 target pixels."""
    rng = np.random.default_rng(seed)
    waves = [(rng.uniform(0.3, 1.2), rng.uniform(0.0, np.pi), rng.uniform(0.0, 6.0)) for _ in range(4)]
    total = sum(np.sin(k * (x * np.cos(a) + y * np.sin(a)) + p) for k, a, p in waves)
    return np.stack([0.5 + 0.1 * total * (1.0 - 0.1 * c) for c in range(3)], axis=-1)


class World:
    """The visible surfaces at positions ``(x, y)`` in frame ``t`` of a clip."""

    def __init__(self, x: Array, y: Array, t: int, clip: int, speed: float = 1.0) -> None:
        plane, square = (v * speed for v in (PLANE, SQUARE))
        corner = np.array((55.0, 5.0)) + square * t
        self.front = (abs(x - corner[0] - SIDE / 2) < SIDE / 2) & (abs(y - corner[1] - SIDE / 2) < SIDE / 2)
        front = self.front[..., None]
        behind = texture(x - plane[0] * t, y - plane[1] * t, 2 * clip)
        self.shown = np.where(front, texture(x - square[0] * t, y - square[1] * t, 2 * clip + 1), behind)
        self.depth = np.where(front, 0.2, 0.5 + 0.3 * (y[..., None] / SIZE[1]))
        self.motion = np.where(front, -square, -plane) / np.array(SIZE)
        self.normal = np.where(front, (0.6, 0.0, 0.8), (0.0, -0.28, 0.96))
        self.lit = 0.3 + self.shown**2
        self.material = 0.25 + 0.5 * self.shown[..., ::-1]
        self.emission = np.where((x + y < 20.0)[..., None], 4.0 * self.shown, 0.0)

    @property
    def radiance(self) -> Array:
        return self.material * self.lit + self.emission


def grid(width: int, height: int, step: float, offset: tuple[float, float] = (0.0, 0.0)) -> tuple[Array, Array]:
    y, x = np.mgrid[0:height, 0:width] + 0.5
    return (x + offset[0]) * step, (y + offset[1]) * step


def frame(t: int, clip: int, scale: int, jitter: NDArray[np.float32], speed: float) -> dict[str, NDArray]:
    """Return all buffers of one frame."""
    low = World(*grid(SIZE[0] // scale, SIZE[1] // scale, scale, tuple(jitter)), t, clip, speed)
    high = World(*grid(*SIZE, 1.0), t, clip, speed)
    fine = [World(*grid(*SIZE, 1.0, (dx, dy)), t, clip, speed) for dx in (-0.25, 0.25) for dy in (-0.25, 0.25)]
    return {
        "color": low.shown, "radiance": low.radiance, "depth": low.depth, "motion": low.motion,
        "motion_dual": low.motion * 0.5, "jitter": jitter, "normal": low.normal, "material": low.material,
        "emission": low.emission, "target": np.mean([f.shown for f in fine], axis=0), "target_radiance": high.radiance,
        "high_motion": high.motion, "high_material": high.material, "high_emission": high.emission,
    }  # fmt: skip


def make_source(
    folder: Path,
    clips: int = 2,
    frames: int = 5,
    scale: int = 2,
    jittered: bool = True,
    speed: float = 1.0,
    names: list[str] = ALL,
    split: str = "test",
) -> Path:
    """Write a data set file of the world."""
    folder.mkdir(parents=True, exist_ok=True)
    spec = CaptureSpec(
        scene="closed/World",
        split=split,
        clips=clips,
        frames=frames,
        targets=frames,
        frame=SIZE,
        window=SIZE,
        scale=scale,
        jitter="none",
        mip_bias="matched",
        samples=1,
        seed=0,
        candidates=1,
    )
    parts = []
    for clip in range(clips):
        parts.append(folder / f"part{clip}.h5")
        with ClipWriter(parts[-1], dict.fromkeys(names, frames)) as writer:
            for t in range(frames):
                offset = JITTER[(t + clip) % len(JITTER)] * jittered
                buffers = frame(t, clip, scale, offset, speed)
                for name in names:
                    writer.add(name, buffers[name].astype(np.float32))
    path = folder / spec.file_name
    join_clips(path, spec, parts, frozenset(names), {"renderer": "closed form"})
    return path
