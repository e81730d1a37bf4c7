"""Pictures of compared runs side by side, with their reference: crops, error maps, epipolar images."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from supersampling.reporting.figures.crops import DETAIL, error_maps, psnr_text
from supersampling.reporting.figures.pictures import Image8, framed, magnify, positions, read, worst_window
from supersampling.reporting.pages.section import GalleryRow, Picture
from supersampling.reporting.pages.sheet import Text

SCENES = 3
WIDTH = 64  # of epipolar images
INPUT, TARGET = "input", "target"
Folders = Mapping[str, Path]
"""The folder of a kind of picture by label."""


@dataclass(frozen=True)
class Shot:
    """An image below its column's head, and the target of its run."""

    head: str
    image: Image8
    target: Image8

    @property
    def is_target(self) -> bool:
        return self.image is self.target


@dataclass(frozen=True)
class Scene:
    """The pictures of one scene, from left to right."""

    stem: str
    name: str
    shots: list[Shot]

    @property
    def spread(self) -> float:
        """The mean absolute difference of the runs' images from their mean; of a single run, from its target."""
        images, reference = contrast(self.shots)
        return float(np.mean([np.abs(image - reference).mean() for image in images]))

    @property
    def equal_sizes(self) -> bool:
        return len({shot.image.shape for shot in self.shots}) == 1


def contrast(shots: Sequence[Shot]) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the runs' images (of one size), and their mean; instead of it the target for a single one."""
    images = [shot.image.astype(np.float64) for shot in shots if not shot.is_target and shot.head != INPUT]
    images = [image for image in images if image.shape == images[0].shape]
    return images, np.mean(images, axis=0) if len(images) > 1 else shots[-1].target.astype(np.float64)


def read_scenes(folders: Folders, only: Sequence[str], with_input: bool) -> list[Scene]:
    """Return the scenes that every label has, of ``only`` if it is not empty.

    If all runs have the same targets, one stands at the end, and their input, if it is the same as well, in front;
    otherwise each run's own target stands beside its image, and no input is drawn.
    """
    scenes = []
    for number, scene in positions(list(folders.values())):
        stem = f"{number}_{scene}"
        paths = [folder / f"{stem}{suffix}.png" for folder in folders.values() for suffix in ("", "_target")]
        if all(path.is_file() for path in paths) and (not only or scene in only):
            scenes.append((stem, scene))
    targets = {stem: [read(folder / f"{stem}_target.png") for folder in folders.values()] for stem, _ in scenes}
    inputs = {stem: [folder / f"{stem}_input.png" for folder in folders.values()] for stem, _ in scenes}
    shared = all(_equal(images) for images in targets.values())
    with_input = with_input and shared and all(_same_files(paths) for paths in inputs.values())
    result = []
    for stem, scene in scenes:
        shots = []
        for (label, folder), target in zip(folders.items(), targets[stem]):
            shots.append(Shot(label, read(folder / f"{stem}.png"), targets[stem][0] if shared else target))
            if not shared:
                shots.append(Shot(TARGET, target, target))
        if shared:
            shots.append(Shot(TARGET, targets[stem][0], targets[stem][0]))
        if with_input:
            shots.insert(0, Shot(INPUT, read(inputs[stem][0]), targets[stem][0]))
        result.append(Scene(stem, scene, shots))
    return result


def _equal(images: Sequence[Image8]) -> bool:
    return all(np.array_equal(image, images[0]) for image in images)


def _same_files(paths: Sequence[Path]) -> bool:
    return all(path.is_file() for path in paths) and _equal([read(path) for path in paths])


def most_different(scenes: Sequence[Scene]) -> list[Scene]:
    """Return the scenes whose images differ most, in their own order."""
    ranked = sorted(scenes, key=lambda scene: -scene.spread)[:SCENES]
    return [scene for scene in scenes if scene in ranked]


def crop_row(scene: Scene, out: Path, prefix: str, with_errors: bool) -> GalleryRow:
    """Return a scene's crops, the details where they differ most, the runs' errors if requested, and their PSNR."""
    shots, details = scene.shots, [_detail(shot, scene) for shot in scene.shots]
    names = [f"{prefix}_{scene.stem}_{index}" for index in range(len(shots))]
    for shot, (x, y, side), name in zip(shots, details, names):
        framed(shot.image, x, y, side, side).save(out / f"{name}.png")
        magnify(shot.image[y : y + side, x : x + side]).save(out / f"{name}_detail.png")
    lines: list[list[Picture | Text]] = [
        [Picture(f"{name}.png") for name in names],
        [Picture(f"{name}_detail.png") for name in names],
    ]
    if with_errors:
        compared = {name: shot for name, shot in zip(names, shots) if not shot.is_target and shot.head != INPUT}
        maps, worst = error_maps([s.image for s in compared.values()], [s.target for s in compared.values()])
        for name, painted in zip(compared, maps):
            magnify(painted).save(out / f"{name}_error.png")
        scale = Text(f"error\n0 to {worst:.0f}\nof 255")
        blank = [Text("") if shot.head == INPUT else scale for shot in shots]
        lines.append([Picture(f"{n}_error.png") if n in compared else text for n, text in zip(names, blank)])
    lines.append([Text("PSNR (dB)" if shot.is_target else psnr_text(shot.image, shot.target)) for shot in shots])
    return GalleryRow(scene.name, lines)


def _detail(shot: Shot, scene: Scene) -> tuple[int, int, int]:
    """Return ``(x, y, side)`` of the detail: the same for all images of a scene that have the same size."""
    side = max(1, min(shot.image.shape[:2]) // DETAIL)
    if scene.equal_sizes:
        x, y = worst_window(*contrast(scene.shots), side, side)
    else:
        outputs = [s.image for s in scene.shots if s.target is shot.target and not s.is_target]
        x, y = worst_window(outputs, shot.target, side, side)
    return x, y, side


def epipolar_row(scene: Scene, out: Path, prefix: str) -> GalleryRow:
    """Return the columns of a scene's epipolar images where they differ most."""
    line: list[Picture | Text] = []
    for index, shot in enumerate(scene.shots):
        width = min(WIDTH, shot.image.shape[1])
        outputs, reference = contrast(scene.shots) if scene.equal_sizes else ([shot.image], shot.target)
        x, _ = worst_window(outputs, reference, width, len(shot.image))
        name = f"{prefix}_{scene.stem}_{index}.png"
        magnify(shot.image[:, x : x + width]).save(out / name)
        line.append(Picture(name))
    return GalleryRow(scene.name, [line])
