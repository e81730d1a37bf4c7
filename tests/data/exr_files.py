"""EXR files of random parts, layers, windows, types and compressions, and what they contain."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import OpenEXR

SIZE = (12, 10)
LAYERS = ("", "", "", "albedo.", "View.Combined.", "left.", "right.")
NAMES = ("RGB", "RGBA", "RGB", "RG", "XYZ", "Z", "Y", "R", "RGBZ")
EXACT = [
    getattr(OpenEXR, f"{name}_COMPRESSION")
    for name in ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "HTJ2K32", "HTJ2K256", "ZSTD")
    if hasattr(OpenEXR, f"{name}_COMPRESSION")
]
LOSSY = [getattr(OpenEXR, f"{name}_COMPRESSION") for name in ("PXR24", "B44", "B44A", "DWAA", "DWAB")]


class Content(NamedTuple):
    """What a file contains."""

    display: tuple[int, int, int, int]
    """First and last pixel of the image."""
    parts: list[tuple[str, tuple[int, int, int, int], dict[str, np.ndarray]]]
    """Name, first and last stored pixel, and the channels of each part."""
    coarse: set[tuple[int, str]]
    """Part and name of the channels that are stored at half of the resolution."""


def random_exr(path: Path, rng: np.random.Generator, compressions: Sequence[OpenEXR.Compression] = EXACT) -> Content:
    """Write a small file and return what it contains."""
    left, top = (int(n) for n in rng.integers(-3, 4, 2) * rng.integers(0, 2))
    display = (left, top, left + SIZE[0] - 1, top + SIZE[1] - 1)
    count = int(rng.choice([1, 1, 1, 2, 3]))
    content, parts = Content(display, [], set()), []
    for number in range(count):
        data = display
        if rng.random() < 0.3:
            data = tuple(int(a + b * rng.choice([0, 2, 4])) for a, b in zip(display, (-1, -1, 1, 1)))
            if rng.random() < 0.3:
                data = tuple(int(a + rng.integers(0, 3)) for a in data)
        planes = _channels(rng, (data[3] - data[1] + 1, data[2] - data[0] + 1))
        header = {
            "type": OpenEXR.scanlineimage,
            "compression": compressions[rng.integers(len(compressions))],
            "lineOrder": [OpenEXR.INCREASING_Y, OpenEXR.DECREASING_Y][rng.integers(2)],
            "dataWindow": _window(data),
            "displayWindow": _window(display),
        }
        channels: dict[str, object] = dict(planes)
        if rng.random() < 0.2:
            tiles = OpenEXR.TileDescription()
            tiles.xSize, tiles.ySize = (int(n) for n in rng.integers(3, 20, 2))
            header |= {"type": OpenEXR.tiledimage, "tiles": tiles}
        elif rng.random() < 0.15 and not any((*np.array(data[:2]) % 2, *(np.array(data[2:]) + 1) % 2)):
            name = sorted(planes)[rng.integers(len(planes))]
            channels[name] = OpenEXR.Channel(name, planes[name], 2, 2)
            content.coarse.add((number, name))
        title = ("N", "albedo", "beauty")[number] if count > 1 else ""
        content.parts.append((title, data, planes))
        parts.append(OpenEXR.Part(header, channels, title))
    OpenEXR.File(parts).write(str(path))
    return content


def _channels(rng: np.random.Generator, shape: tuple[int, int]) -> dict[str, np.ndarray]:
    planes = {}
    for layer in rng.choice(LAYERS, rng.integers(1, 4)):
        for name in NAMES[rng.integers(len(NAMES))]:
            planes[f"{layer}{name}"] = _plane(rng, shape, name)
    return planes


def _plane(rng: np.random.Generator, shape: tuple[int, int], name: str) -> np.ndarray:
    kind = rng.integers(0, 6)
    if name == "A" and kind:
        return np.ones(shape, dtype=[np.float16, np.float32][rng.integers(2)])
    if kind == 0:
        return rng.integers(0, 1 << (24 if rng.random() < 0.8 else 32), shape).astype(np.uint32)
    if kind in (1, 2):
        return (60000.0 * rng.random(shape) ** 8).astype(np.float16)
    values = np.ldexp(rng.random(shape), rng.integers(-130, 100, shape)).astype(np.float32)
    if rng.random() < 0.05:
        values[0, 0] = rng.choice([np.nan, np.inf])
    return values


def _window(corners: tuple[int, int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    return np.array(corners[:2], dtype=np.int32), np.array(corners[2:], dtype=np.int32)
