"""Facts about a scene, measured in the files of its data set, or read from its manifest if the files lack them."""

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
FrameValues = Callable[[Clip, int], Iterator[float]]
TEXTURED = 0.02  # variation of a material within a rendered pixel, relative to its largest value
STANDING = 0.01  # target pixels
DILATED = 0.1  # rendered pixels, as in the mask of dual motion vectors
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
    yield from (np.abs(clip["motion"] * size) < STANDING).all(axis=1).mean(axis=(1, 2))


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
    yield from motion_mask(offset, (height, width), DILATED).mean(dim=(1, 2, 3)).tolist()


def _textured(clip: Clip, scale: int) -> Iterator[float]:
    for frame in clip["high_material"]:
        channels, height, width = frame.shape
        blocks = frame.reshape(channels, height // scale, scale, width // scale, scale)
        high, low = blocks.max(axis=(2, 4)), blocks.min(axis=(2, 4))
        surface = high.max(axis=0) > 0  # the sky has no material
        textured = ((high - low) > TEXTURED * high).any(axis=0)
        yield float(textured[surface].mean()) if surface.any() else 0.0


def _sky(clip: Clip, scale: int) -> Iterator[float]:
    yield from (clip["depth"] >= 1.0).mean(axis=(1, 2, 3))


def _glossy(clip: Clip, scale: int) -> Iterator[float]:
    surface = clip["depth"] < 1.0
    yield from ((clip["roughness"] < GLOSSY) & surface).sum(axis=(1, 2, 3)) / np.maximum(surface.sum(axis=(1, 2, 3)), 1)


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """The measurement of a fact: ``frames`` yields values of a clip's ``buffers``, ``combine`` reduces all of them."""

    buffers: tuple[str, ...]
    frames: FrameValues
    combine: Callable[..., float]
    about: str


MEASUREMENTS = {
    "largest_motion": Measurement(
        buffers=("motion",), frames=_largest_motion, combine=np.max, about="largest motion, target pixels per frame"
    ),
    "standing_pixels": Measurement(
        buffers=("motion",),
        frames=_standing,
        combine=np.mean,
        about="share of pixels that move by less than 0.01 target pixels",
    ),
    "new_frames": Measurement(
        buffers=("color",),
        frames=_new,
        combine=np.mean,
        about="share of rendered frames that differ from the previous one",
    ),
    "jitters": Measurement(buffers=("jitter",), frames=_jitters, combine=np.max, about="different jitters in a clip"),
    "dual_pixels": Measurement(
        buffers=("motion", "motion_dual"),
        frames=_dual,
        combine=np.mean,
        about="share of pixels in the mask of dual motion vectors",
    ),
    "dilated_pixels": Measurement(
        buffers=("motion", "depth"),
        frames=_dilated,
        combine=np.mean,
        about="share of pixels whose motion changes by more than a tenth of a rendered pixel with dilation",
    ),
    "textured_pixels": Measurement(
        buffers=("high_material",),
        frames=_textured,
        combine=np.mean,
        about="share of rendered pixels within which the material varies by more than 2%",
    ),
    "sky_pixels": Measurement(buffers=("depth",), frames=_sky, combine=np.mean, about="share of sky pixels"),
    "glossy_pixels": Measurement(
        buffers=("roughness", "depth"),
        frames=_glossy,
        combine=np.mean,
        about="share of surfaces with a roughness below 0.4",
    ),
}
# Numbers of a manifest that describe the scene, for what the files do not show.
MANIFEST_FACTS = {
    "moving_pixels": "share of pixels on moving objects",
    "disoccluded_pixels": "share of pixels that were hidden one frame before",
    "speed_median": "median of the motion, target pixels of 1080p per frame",
    "glossy_pixels": "share of surfaces with a roughness below 0.4",
    "fine_texture_pixels": "share of surfaces whose albedo varies by more than 20% within a 270p pixel",
    "lighting_energy_ratio": "gradient energy of lighting relative to that of radiance",
    "shadow_change_pixels": "share of static surfaces where a shadow changes within 0.25 s",
    "static_paths": "share of paths whose camera never moves",
}


def measure_facts(paths: Sequence[Path], scenes: Sequence[str]) -> dict[str, Fact]:
    """Return the facts of a scene.

    The built-in scenes' manifests come first, of which the largest number counts; then, in place of equal names, every
    fact that the buffers of all files allow, over all of their frames.
    """
    values: dict[str, list[float]] = defaultdict(list)
    missing: set[str] = set()
    for path in paths:
        file = DatasetFile(path)
        for name, measurement in MEASUREMENTS.items():
            buffers = measurement.buffers
            if not file.buffers.issuperset(buffers):
                missing.add(name)
                continue
            start = file.spec.frames - file.spec.targets if buffers[0].startswith("high_") else 0
            for index in range(file.clips):
                clip = {buffer: file.read(buffer, index, slice(start, None)) for buffer in buffers}
                values[name] += measurement.frames(clip, file.spec.scale)
        file.close()
    facts = {
        name: Fact(float(measurement.combine(values[name])), "files", measurement.about)
        for name, measurement in MEASUREMENTS.items()
        if values[name] and name not in missing
    }
    return _read_manifests(scenes) | facts


def _read_manifests(scenes: Sequence[str]) -> dict[str, Fact]:
    values: dict[str, list[float]] = defaultdict(list)
    for scene in scenes:
        try:
            measured = load_manifest(scene).measured
        except UserError:
            return {}
        for name in MANIFEST_FACTS:
            value = measured.get(name)
            if value is not None:
                values[name].append(value)
    return {
        name: Fact(max(values[name]), "manifest", about)
        for name, about in MANIFEST_FACTS.items()
        if len(values[name]) == len(scenes)
    }
