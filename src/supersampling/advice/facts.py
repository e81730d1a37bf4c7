"""What a scene has, measured from its data set's files, and what its manifest says where the files do not hold it."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError
from supersampling.ops.motion_mask import motion_mask
from supersampling.scenes.manifest import load_manifest
from supersampling.stages.dilate import ClosestDepth

Clip = Mapping[str, NDArray[np.float32]]
Measure = Callable[[Clip, int], Iterator[float]]
VARIES = 0.02  # of a material within a rendered pixel, relative to its largest value
STANDS = 0.01  # target pixels
APART = 0.1  # rendered pixels, as of the mask of dual motion vectors
GLOSSY = 0.4  # as in the manifests


@dataclass(frozen=True)
class Fact:
    """A number about a scene; ``source`` is ``files`` or ``manifest``."""

    value: float
    source: str
    about: str


def _largest_motion(clip: Clip, scale: int) -> Iterator[float]:
    height, width = clip["motion"].shape[-2:]
    size = np.array((width, height), dtype=np.float32)[:, None, None] * scale
    yield from np.abs(clip["motion"] * size).max(axis=(1, 2, 3))


def _standing(clip: Clip, scale: int) -> Iterator[float]:
    height, width = clip["motion"].shape[-2:]
    size = np.array((width, height), dtype=np.float32)[:, None, None] * scale
    yield from (np.abs(clip["motion"] * size) < STANDS).all(axis=1).mean(axis=(1, 2))


def _new(clip: Clip, scale: int) -> Iterator[float]:
    color = clip["color"]
    yield from (np.abs(color[1:] - color[:-1]).max(axis=(1, 2, 3)) > 0).astype(float)


def _jitters(clip: Clip, scale: int) -> Iterator[float]:
    yield float(len(np.unique(clip["jitter"], axis=0)))


def _dual(clip: Clip, scale: int) -> Iterator[float]:
    offset = torch.from_numpy(clip["motion_dual"] - clip["motion"])
    height, width = offset.shape[-2:]
    yield from motion_mask(offset, (height, width)).mean(dim=(1, 2, 3)).tolist()


def _dilated(clip: Clip, scale: int) -> Iterator[float]:
    motion, depth = (torch.from_numpy(clip[name]) for name in ("motion", "depth"))
    height, width = motion.shape[-2:]
    offset = ClosestDepth()(motion, depth) - motion
    yield from motion_mask(offset, (height, width), APART).mean(dim=(1, 2, 3)).tolist()


def _textured(clip: Clip, scale: int) -> Iterator[float]:
    for frame in clip["high_material"]:
        channels, height, width = frame.shape
        blocks = frame.reshape(channels, height // scale, scale, width // scale, scale)
        high, low = blocks.max(axis=(2, 4)), blocks.min(axis=(2, 4))
        surface = high.max(axis=0) > 0
        varies = ((high - low) > VARIES * high).any(axis=0)
        yield float(varies[surface].mean()) if surface.any() else 0.0


def _sky(clip: Clip, scale: int) -> Iterator[float]:
    yield from (clip["depth"] >= 1.0).mean(axis=(1, 2, 3))


def _glossy(clip: Clip, scale: int) -> Iterator[float]:
    surface = clip["depth"] < 1.0
    yield from ((clip["roughness"] < GLOSSY) & surface).sum(axis=(1, 2, 3)) / np.maximum(surface.sum(axis=(1, 2, 3)), 1)


# name: (buffers, measure of every frame, how frames are put together, what it is)
MEASURES: dict[str, tuple[tuple[str, ...], Measure, Callable[..., float], str]] = {
    "largest_motion": (("motion",), _largest_motion, np.max, "largest motion, target pixels a frame"),
    "standing_pixels": (("motion",), _standing, np.mean, "share of pixels that move by under 0.01 target pixels"),
    "new_frames": (("color",), _new, np.mean, "share of rendered frames that differ from the one before"),
    "jitters": (("jitter",), _jitters, np.max, "different jitters of a clip"),
    "dual_pixels": (("motion", "motion_dual"), _dual, np.mean, "share of pixels in the mask of dual motion vectors"),
    "dilated_pixels": (
        ("motion", "depth"), _dilated, np.mean,
        "share of pixels whose motion dilation changes by over a tenth of a rendered pixel",
    ),
    "textured_pixels": (
        ("high_material",), _textured, np.mean, "share of rendered pixels within which the material varies by over 2%"
    ),
    "sky_pixels": (("depth",), _sky, np.mean, "share of pixels of the sky"),
    "glossy_pixels": (("roughness", "depth"), _glossy, np.mean, "share of surfaces with a roughness below 0.4"),
}  # fmt: skip
# A manifest's numbers that say something of the scene; the first two stand in for what the files may lack.
FROM_MANIFEST = {
    "moving_pixels": "share of pixels on moving objects",
    "disoccluded_pixels": "share of pixels that were hidden one frame before",
    "speed_median": "median of the motion, target pixels of 1080p a frame",
    "glossy_pixels": "share of surfaces with a roughness below 0.4",
    "fine_texture_pixels": "share of surfaces whose albedo varies by over 20% within a 270p pixel",
    "lighting_energy_ratio": "gradient energy of lighting over that of radiance",
    "shadow_change_pixels": "share of standing surfaces where a shadow changes within 0.25 s",
    "static_paths": "share of paths whose camera stands from beginning to end",
}


def measure(paths: Sequence[Path], scenes: Sequence[str]) -> dict[str, Fact]:
    """Every fact that the files' buffers allow, over all of their frames, then those of the built-in scenes' manifests, of which
    the largest counts."""
    found: dict[str, list[float]] = defaultdict(list)
    lacking: set[str] = set()
    for path in paths:
        store = DatasetFile(path)
        for name, (buffers, of_clip, _, _) in MEASURES.items():
            if not store.buffers.issuperset(buffers):
                lacking.add(name)
                continue
            late = store.spec.frames - store.spec.targets if buffers[0].startswith("high_") else 0
            for index in range(store.clips):
                clip = {buffer: store.read(buffer, index, slice(late, None)) for buffer in buffers}
                found[name] += of_clip(clip, store.spec.scale)
        store.close()
    facts = {
        name: Fact(float(put(found[name])), "files", about)
        for name, (_, _, put, about) in MEASURES.items()
        if found[name] and name not in lacking
    }
    return _of_manifests(scenes) | facts


def _of_manifests(scenes: Sequence[str]) -> dict[str, Fact]:
    said: dict[str, list[float]] = defaultdict(list)
    for scene in scenes:
        try:
            measured = load_manifest(scene).measured
        except UserError:
            return {}
        for name in FROM_MANIFEST:
            value = measured.get(name)
            if value is not None:
                said[name].append(value)
    return {
        name: Fact(max(said[name]), "manifest", about)
        for name, about in FROM_MANIFEST.items()
        if len(said[name]) == len(scenes)
    }
