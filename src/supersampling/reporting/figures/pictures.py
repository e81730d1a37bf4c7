"""The pictures that runs keep of a scene's first clip: finding, reading, magnifying and framing them."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from supersampling.reporting.methods import Method

MIN_PIXELS = 192
FRAME = (230, 159, 0)
_NAME = re.compile(r"(?P<number>\d+)_(?P<scene>.+?)(?P<kind>_target|_input)?\.png")
Image8 = NDArray[np.uint8]


def folders_by_label(methods: Sequence[Method], folders: Mapping[str, Path]) -> dict[str, Path]:
    """Return each method's folder of pictures by its label; a method without pictures is left out.

    ``folders`` are the downloaded ones by run id; a method's first run that has one counts.
    """
    by_label = {m.label: next((folders[run.id] for run in m.runs if run.id in folders), None) for m in methods}
    return {label: folder for label, folder in by_label.items() if folder is not None}


def positions(folders: Sequence[Path]) -> list[tuple[str, str]]:
    """Return ``(number, scene)`` of the pictures, by number."""
    names = {path.name for folder in folders for path in folder.glob("*.png")}
    matched = [match for name in names if (match := _NAME.fullmatch(name)) and match["kind"] is None]
    distinct = {(match["number"], match["scene"]) for match in matched}
    return sorted(distinct, key=lambda position: (int(position[0]), position[1]))


def read(path: Path) -> Image8:
    """Return an image as ``(H, W, 3)``."""
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def read_equal(paths: Sequence[Path]) -> list[Image8] | None:
    """Return the images; None if one is missing or they differ in size, since places would not compare."""
    if not all(path.is_file() for path in paths):
        return None
    images = [read(path) for path in paths]
    return images if len({image.shape for image in images}) == 1 else None


def magnify(image: Image8) -> Image.Image:
    """Return the image with every pixel as a square of whole pixels, so that no viewer smooths it."""
    factor = max(1, -(-MIN_PIXELS // max(image.shape[:2])))
    return Image.fromarray(image.repeat(factor, axis=0).repeat(factor, axis=1))


def framed(image: Image8, x: int, y: int, width: int, height: int) -> Image.Image:
    """Return the magnified image with a rectangle around ``width x height`` pixels at ``(x, y)``."""
    marked = magnify(image)
    factor = marked.width // image.shape[1]
    box = (x * factor, y * factor, (x + width) * factor - 1, (y + height) * factor - 1)
    ImageDraw.Draw(marked).rectangle(box, outline=FRAME, width=max(1, marked.width // 100))
    return marked


def worst_window(outputs: Sequence[NDArray[Any]], target: NDArray[Any], width: int, height: int) -> tuple[int, int]:
    """Return the top-left ``(x, y)`` of the window with the largest absolute error summed over the methods."""
    error = np.asarray(sum(np.abs(image.astype(np.float64) - target).mean(axis=2) for image in outputs))
    table = np.pad(error.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    sums = table[height:, width:] - table[:-height, width:] - table[height:, :-width] + table[:-height, :-width]
    y, x = np.unravel_index(int(sums.argmax()), sums.shape)
    return int(x), int(y)
