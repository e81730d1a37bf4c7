"""The table of image crops: input, methods, target, each with a magnified detail and its error."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import colormaps

from supersampling.reporting.figures.pictures import (
    Image8,
    folder_of,
    framed,
    magnify,
    positions,
    read,
    worst_window,
)
from supersampling.reporting.pages.overview import Method, short_labels

DETAIL = 4
WORST = 0.995


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

    ``folders`` are the downloaded crop folders by run id.
    """
    present = folder_of(found, folders)
    columns = ["input", *short_labels(list(present)), "target"]
    rows: list[CropRow] = []
    for number, scene in positions(list(present.values())):
        stem = f"{number}_{scene}"
        paths = _paths(present, stem)
        if paths is None:
            continue
        images = [read(path) for path in paths]
        if len({image.shape for image in images}) == 1:
            rows.append(_row(stem, f"{scene} {number}", images, out))
    return CropTable(columns, rows)


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
    side = max(1, min(target.shape[:2]) // DETAIL)
    x, y = worst_window(images[1:-1], target, side, side)
    names: list[str] = []
    details: list[str] = []
    differences = [np.abs(image.astype(np.float64) - target).mean(axis=2) for image in images[:-1]]
    # One scale for all columns; a few pixels alone would make the rest dark.
    worst = max(1.0, float(np.quantile(np.stack(differences), WORST)))
    errors = [f"crop_{stem}_{index}_error.png" for index in range(len(differences))]
    for name, difference in zip(errors, differences):
        painted = colormaps["magma"](np.clip(difference / worst, 0, 1), bytes=True)[..., :3]
        magnify(painted).save(out / name)
    for index, image in enumerate(images):
        names.append(f"crop_{stem}_{index}.png")
        details.append(f"crop_{stem}_{index}_detail.png")
        framed(image, x, y, side, side).save(out / names[-1])
        magnify(image[y : y + side, x : x + side]).save(out / details[-1])
    scores = [_psnr(image, target) for image in images[:-1]]
    return CropRow(label, names, details, errors, f"{worst:.0f}", [*scores, "PSNR (dB)"])


def _psnr(image: Image8, target: Image8) -> str:
    error = float(np.mean((image.astype(np.float64) - target) ** 2))
    return "∞" if error == 0 else f"{10 * np.log10(255**2 / error):.2f}"
