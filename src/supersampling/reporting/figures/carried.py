"""Pictures of what methods carry or compute, beside the crop of the target: buffers, masks, weights (see `crops`)."""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from supersampling.reporting.figures.pictures import positions
from supersampling.reporting.figures.side_by_side import SCENES, TARGET, Folders
from supersampling.reporting.pages.section import Gallery, GalleryRow, Picture
from supersampling.reporting.pages.sheet import Text

# The names of a kind's pictures in the folder state/; * stands for a number.
NAMES = {
    "accumulation": ["accumulation"],
    "reweighting": ["reweighting_*"],
    "blending": ["reprojected", "candidate", "mask"],
}
WITH_ENDS = {"blending"}  # between the input and the output
OVER_TIME = "mask"


def state_gallery(kind: str, states: Folders, crops: Folders, out: Path, prefix: str) -> Gallery:
    """Copy pictures of the folders ``state`` beside the targets' crops to ``out``, both by label; a row per scene.

    A row has each label's pictures with the target of its run.
    """
    labels = [label for label in states if label in crops]
    rows: list[GalleryRow] = []
    heads: list[str] = []
    for number, scene in positions([crops[label] for label in labels]):
        columns: list[tuple[str, Path]] = []
        for label in labels:
            stem = f"{number}_{scene}"
            columns += _columns(kind, label, len(labels) > 1, states[label], crops[label], stem)
        present = all(path.is_file() for _, path in columns)
        if columns and present and len(rows) < SCENES:
            heads = heads or [head for head, _ in columns]
            rows.append(GalleryRow(scene, [_copies([path for _, path in columns], out, f"{prefix}_{len(rows)}")]))
    return Gallery(heads, rows, [])


def _columns(kind: str, label: str, several: bool, state: Path, crops: Path, stem: str) -> list[tuple[str, Path]]:
    """Return heads and files of one run's pictures; none if it has no picture of the kind."""
    paths = [path for name in NAMES[kind] for path in sorted(state.glob(f"{stem}_{name}.png"))]
    if not paths:
        return []
    names = [path.stem.removeprefix(f"{stem}_").replace("_", " ") for path in paths]
    heads = [label] if len(names) == 1 else [f"{label} {name}" if several else name for name in names]
    columns = list(zip(heads, paths))
    if kind in WITH_ENDS:
        columns = [("input", crops / f"{stem}_input.png"), *columns, ("output", crops / f"{stem}.png")]
    return [*columns, (TARGET, crops / f"{stem}_target.png")]


def over_time_gallery(steps: Folders, out: Path, prefix: str) -> Gallery:
    """Copy each scene's strip of consecutive frames to ``out``, a row for each scene and label."""
    rows: list[GalleryRow] = []
    scenes = _scenes_over_time(steps)
    for scene in scenes[:SCENES]:
        for label, folder in steps.items():
            pictures = _copies([folder / f"{scene}_{OVER_TIME}.png"], out, f"{prefix}_{len(rows)}")
            rows.append(GalleryRow(f"{label}\n{scene.partition('_')[2]}", [pictures]))
    return Gallery(["consecutive frames, from left to right"], rows, [])


def _scenes_over_time(steps: Mapping[str, Path]) -> list[str]:
    """Return ``<number>_<scene>`` of the strips that every label has."""
    names = [
        {path.stem.removesuffix(f"_{OVER_TIME}") for path in folder.glob(f"*_{OVER_TIME}.png")}
        for folder in steps.values()
    ]
    common = set.intersection(*names) if names else set()
    return sorted(common, key=lambda stem: (int(stem.split("_")[0]), stem))


def _copies(paths: Sequence[Path], out: Path, prefix: str) -> list[Picture | Text]:
    pictures: list[Picture | Text] = []
    for index, path in enumerate(paths):
        name = f"{prefix}_{index}.png"
        shutil.copyfile(path, out / name)
        pictures.append(Picture(name))
    return pictures
