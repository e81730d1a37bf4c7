"""The table of epipolar images: a row of pixels of every frame, time downwards (NSRD, figure 6)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from supersampling.reporting.figures.pictures import folder_of, magnify, positions, read, worst_window
from supersampling.reporting.pages.overview import Method, short_labels

WIDTH = 64


@dataclass(frozen=True)
class EpipolarRow:
    """A scene, and the chosen columns of every method's image and of the target's."""

    label: str
    images: list[str]


@dataclass(frozen=True)
class EpipolarTable:
    """Columns are the methods and the target."""

    columns: list[str]
    rows: list[EpipolarRow]


def epipolar_table(found: Sequence[Method], folders: Mapping[str, Path], out: Path) -> EpipolarTable:
    """Write, of each scene, the `WIDTH` columns where the methods err most as PNGs to ``out``.

    ``folders`` are the downloaded folders by run id. A scene that one of the methods lacks is left out.
    """
    present = folder_of(found, folders)
    rows: list[EpipolarRow] = []
    for number, scene in positions(list(present.values())):
        stem = f"{number}_{scene}"
        first = next(iter(present.values()))
        paths = [*(folder / f"{stem}.png" for folder in present.values()), first / f"{stem}_target.png"]
        if not all(path.is_file() for path in paths):
            continue
        images = [read(path) for path in paths]
        if len({image.shape for image in images}) > 1:
            continue
        target = images[-1]
        width = min(WIDTH, target.shape[1])
        x, _ = worst_window(images[:-1], target, width, len(target))
        names = [f"epipolar_{stem}_{i}.png" for i in range(len(images))]
        for name, image in zip(names, images):
            magnify(image[:, x : x + width]).save(out / name)
        rows.append(EpipolarRow(scene, names))
    return EpipolarTable([*short_labels(list(present)), "target"], rows)
