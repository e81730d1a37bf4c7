"""Epipolar images: one row of pixels of every frame, time downwards (NSRD, figure 6)."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from supersampling.reporting.figures.pictures import folders_by_label, magnify, positions, read_equal, worst_window
from supersampling.reporting.methods import Method, short_labels
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Gallery, GalleryRow, Picture, Section
from supersampling.reporting.pages.sheet import Text

WIDTH = 64
CAPTION = (
    "The middle row of pixels in every frame of a clip, time downwards; of its columns those where the methods’ summed "
    "absolute error is largest. A stable picture has clean lines like the target’s; flicker is stripes across, "
    "ghosting "
    "a smear."
)


def section(report: Report) -> Section | None:
    """Return the epipolar images of the pictured methods; None without any."""
    gallery = epipolar_gallery(report.pictured, report.material.pictures("epipolar"), report.folder)
    return Section(title="Stability over time", galleries=[gallery]) if gallery.rows else None


def epipolar_gallery(methods: Sequence[Method], folders: Mapping[str, Path], out: Path) -> Gallery:
    """Write the `WIDTH` columns of each scene where the methods err most as PNGs to ``out``.

    ``folders`` are the downloaded folders by run id. Columns are the methods and the target. A scene that one of the
    methods lacks is left out.
    """
    present = folders_by_label(methods, folders)
    rows: list[GalleryRow] = []
    for number, scene in positions(list(present.values())):
        stem = f"{number}_{scene}"
        first = next(iter(present.values()))
        images = read_equal([*(folder / f"{stem}.png" for folder in present.values()), first / f"{stem}_target.png"])
        if images is None:
            continue
        target = images[-1]
        width = min(WIDTH, target.shape[1])
        x, _ = worst_window(images[:-1], target, width, len(target))
        names = [f"epipolar_{stem}_{i}.png" for i in range(len(images))]
        for name, image in zip(names, images):
            magnify(image[:, x : x + width]).save(out / name)
        rows.append(GalleryRow(scene, [[Picture(name) for name in names]]))
    return Gallery([*short_labels(list(present)), "target"], rows, [Text(CAPTION)])
