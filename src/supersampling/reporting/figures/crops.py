"""Image crops: input, methods, target, each with a magnified detail and its error."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps

from supersampling.reporting.figures.pictures import (
    Image8,
    folders_by_label,
    framed,
    magnify,
    positions,
    read_equal,
    worst_window,
)
from supersampling.reporting.methods import Method, short_labels
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Gallery, GalleryRow, Picture, Section
from supersampling.reporting.pages.sheet import Text

DETAIL = 4
WORST = 0.995
CAPTION = (
    "Test crops and, below each, the marked detail magnified: a quarter of the crop’s sides, where the methods’ summed "
    "absolute error is largest; then the absolute error, black for none. The number is the crop’s PSNR in dB. Input: "
    "nearest-neighbour upsampling."
)


def section(report: Report) -> Section | None:
    """Return the crops of the pictured methods; None without any."""
    gallery = crop_gallery(report.pictured, report.material.pictures("crops"), report.folder)
    return Section(title="Crops", galleries=[gallery]) if gallery.rows else None


def crop_gallery(methods: Sequence[Method], folders: Mapping[str, Path], out: Path) -> Gallery:
    """Write each crop and its detail (a quarter of its sides, where the methods err most) as PNGs to ``out``.

    ``folders`` are the downloaded crop folders by run id. Columns are the input, the methods, and the target.
    """
    present = folders_by_label(methods, folders)
    rows: list[GalleryRow] = []
    for number, scene in positions(list(present.values())):
        stem = f"{number}_{scene}"
        first = next(iter(present.values()))
        outputs = [folder / f"{stem}.png" for folder in present.values()]
        images = read_equal([first / f"{stem}_input.png", *outputs, first / f"{stem}_target.png"])
        if images is not None:
            rows.append(_row(stem, f"{scene} {number}", images, out))
    return Gallery(["input", *short_labels(list(present)), "target"], rows, [Text(CAPTION)])


def _row(stem: str, label: str, images: Sequence[Image8], out: Path) -> GalleryRow:
    """Return four lines: the crops, their details, their errors (of every column but the target's), their PSNR."""
    target = images[-1]
    side = max(1, min(target.shape[:2]) // DETAIL)
    x, y = worst_window(images[1:-1], target, side, side)
    maps, worst = error_maps(images[:-1], [target] * (len(images) - 1))
    errors = [f"crop_{stem}_{index}_error.png" for index in range(len(maps))]
    for name, painted in zip(errors, maps):
        magnify(painted).save(out / name)
    names = [f"crop_{stem}_{index}.png" for index in range(len(images))]
    details = [f"crop_{stem}_{index}_detail.png" for index in range(len(images))]
    for image, name, detail in zip(images, names, details):
        framed(image, x, y, side, side).save(out / name)
        magnify(image[y : y + side, x : x + side]).save(out / detail)
    scores = [Text(psnr_text(image, target)) for image in images[:-1]]
    scale = Text(f"error\n0 to {worst:.0f}\nof 255")
    return GalleryRow(
        label,
        [
            [Picture(name) for name in names],
            [Picture(name) for name in details],
            [*(Picture(name) for name in errors), scale],
            [*scores, Text("PSNR (dB)")],
        ],
    )


def error_maps(images: Sequence[Image8], targets: Sequence[Image8]) -> tuple[list[Image8], float]:
    """Return the painted absolute errors, black for none, and the error (of 255) of the brightest colour.

    All have one scale; without the quantile a few pixels would make the rest dark.
    """
    differences = [np.abs(i.astype(np.float64) - t).mean(axis=2) for i, t in zip(images, targets)]
    worst = max(1.0, float(np.quantile(np.stack(differences), WORST)))
    maps = [colormaps["magma"](np.clip(d / worst, 0, 1), bytes=True)[..., :3] for d in differences]
    return maps, worst


def psnr_text(image: Image8, target: Image8) -> str:
    """Return the PSNR of an 8-bit image in dB as text."""
    error = float(np.mean((image.astype(np.float64) - target) ** 2))
    return "∞" if error == 0 else f"{10 * np.log10(255**2 / error):.2f}"
