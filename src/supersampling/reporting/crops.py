"""The table of image crops: input, methods, target, each with a magnified detail and its error."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from supersampling.reporting.overview import Method, short_labels

MAX_CROPS = 6
DETAIL = 4
MIN_PIXELS = 192
WORST = 0.995
FRAME = (230, 159, 0)
_NAME = re.compile(r"(?P<number>\d+)_(?P<scene>.+?)(?P<kind>_target|_input)?\.png")
Image8 = NDArray[np.uint8]


@dataclass(frozen=True)
class CropRow:
    """One crop position: the pictures' file names and their PSNR in dB against the target, by column.

    ``errors`` are maps of the absolute error of 8-bit values, from 0 to ``worst``, of every column but the target's.
    """

    label: str
    images: list[str]
    details: list[str]
    errors: list[str]
    worst: str
    scores: list[str]


@dataclass(frozen=True)
class CropTable:
    """Columns are input, the methods, target."""

    columns: list[str]
    rows: list[CropRow]


def crop_table(found: Sequence[Method], folders: Mapping[str, Path], out: Path) -> CropTable:
    """Write each crop and its detail (a quarter of its sides, where the methods err most) as PNGs to ``out``.

    ``folders`` are the downloaded crop folders by run id; a method's first run that has one stands for it.
    """
    chosen = {m.label: next((folders[run.id] for run in m.runs if run.id in folders), None) for m in found}
    present = {label: folder for label, folder in chosen.items() if folder is not None}
    columns = ["input", *short_labels(list(present)), "target"]
    rows: list[CropRow] = []
    for number, scene in _positions(list(present.values()))[:MAX_CROPS]:
        stem = f"{number}_{scene}"
        paths = _paths(present, stem)
        if paths is None:
            continue
        images = [_read(path) for path in paths]
        if len({image.shape for image in images}) == 1:
            rows.append(_row(stem, f"{scene} {number}", images, out))
    return CropTable(columns, rows)


def _positions(folders: Sequence[Path]) -> list[tuple[str, str]]:
    """``(number, scene)`` of the crops, by number."""
    names = {path.name for folder in folders for path in folder.glob("*.png")}
    matched = [match for name in names if (match := _NAME.fullmatch(name)) and match["kind"] is None]
    found = {(match["number"], match["scene"]) for match in matched}
    return sorted(found, key=lambda position: (int(position[0]), position[1]))


def _paths(folders: Mapping[str, Path], stem: str) -> list[Path] | None:
    """Input, outputs, target; ``None`` if any of them is missing, since a gap would compare different positions."""
    first = next(iter(folders.values()))
    paths = [
        first / f"{stem}_input.png",
        *(f / f"{stem}.png" for f in folders.values()),
        first / f"{stem}_target.png",
    ]
    return paths if all(path.is_file() for path in paths) else None


def _row(stem: str, label: str, images: Sequence[Image8], out: Path) -> CropRow:
    target = images[-1]
    x, y, side = _detail_window(images[1:-1], target)
    names: list[str] = []
    details: list[str] = []
    differences = [np.abs(image.astype(np.float64) - target).mean(axis=2) for image in images[:-1]]
    # One scale for all columns; a few pixels alone would make the rest dark.
    worst = max(1.0, float(np.quantile(np.stack(differences), WORST)))
    errors = [f"crop_{stem}_{index}_error.png" for index in range(len(differences))]
    for name, difference in zip(errors, differences):
        painted = colormaps["magma"](np.clip(difference / worst, 0, 1), bytes=True)[..., :3]
        _magnify(painted).save(out / name)
    for index, image in enumerate(images):
        names.append(f"crop_{stem}_{index}.png")
        details.append(f"crop_{stem}_{index}_detail.png")
        marked = _magnify(image)
        factor = marked.width // image.shape[1]
        box = (x * factor, y * factor, (x + side) * factor - 1, (y + side) * factor - 1)
        ImageDraw.Draw(marked).rectangle(box, outline=FRAME, width=max(1, marked.width // 100))
        marked.save(out / names[-1])
        _magnify(image[y : y + side, x : x + side]).save(out / details[-1])
    scores = [_psnr(image, target) for image in images[:-1]]
    return CropRow(label, names, details, errors, f"{worst:.0f}", [*scores, "PSNR (dB)"])


def _detail_window(outputs: Sequence[Image8], target: Image8) -> tuple[int, int, int]:
    """``(x, y, side)`` of the square with the largest absolute error summed over the methods."""
    error = sum(np.abs(image.astype(np.float64) - target).mean(axis=2) for image in outputs)
    side = max(1, min(target.shape[:2]) // DETAIL)
    table = np.pad(np.asarray(error).cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    sums = table[side:, side:] - table[:-side, side:] - table[side:, :-side] + table[:-side, :-side]
    y, x = np.unravel_index(int(sums.argmax()), sums.shape)
    return int(x), int(y), side


def _magnify(image: Image8) -> Image.Image:
    """Every pixel as a square of whole pixels, so that no viewer smooths it."""
    factor = max(1, -(-MIN_PIXELS // max(image.shape[:2])))
    return Image.fromarray(image.repeat(factor, axis=0).repeat(factor, axis=1))


def _psnr(image: Image8, target: Image8) -> str:
    error = float(np.mean((image.astype(np.float64) - target) ** 2))
    return "∞" if error == 0 else f"{10 * np.log10(255**2 / error):.2f}"


def _read(path: Path) -> Image8:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))
