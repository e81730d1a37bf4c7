"""A folder of frames that another program upscaled, found clip by clip.

``FOLDER/<scene>/<clip>/<anything><number>.<suffix>``; ``<clip>`` counts from 0. The levels that a data set has one of
may be left out: the frames of a single clip may lie in the folder itself. A ``/`` of a scene's name may be a folder or
written ``_``.
"""

import re
from collections.abc import Sequence
from pathlib import Path

from supersampling.data.dataset_file import read_spec
from supersampling.errors import UserError
from supersampling.evaluation.crops import file_name

IMAGES = (".png", ".exr", ".jpg", ".jpeg", ".hdr", ".tif", ".tiff", ".bmp", ".webp", ".tga")


def clip_files(folder: Path, files: Sequence[Path], suffix: str) -> list[list[Path]]:
    """The frames ``*<suffix>`` of every clip of these data set files, in their order.

    Raises:
        UserError: no such folder; a clip without frames; frames of another kind; one missing, one too many, or twice.
    """
    if not folder.is_dir():
        raise UserError(f"There is no folder {folder}: correct frames=.")
    specs = [read_spec(path) for path in files]
    alone = len(specs) == 1
    return [
        _clip(_folder(folder, spec.scene, clip, alone, spec.clips == 1), suffix, spec.frames)
        for spec in specs
        for clip in range(spec.clips)
    ]


def _folder(folder: Path, scene: str, clip: int, one_scene: bool, one_clip: bool) -> Path:
    scenes = [folder / scene, folder / file_name(scene), *([folder] if one_scene else [])]
    places = [place / str(clip) for place in scenes] + (scenes if one_clip else [])
    for place in places:
        if place.is_dir() and any(file.suffix.lower() in IMAGES for file in place.iterdir()):
            return place
    looked = ", ".join(str(place) for place in places)
    raise UserError(f"There are no frames of clip {clip} of {scene}: looked in {looked}.")


def _clip(folder: Path, suffix: str, frames: int) -> list[Path]:
    other = [file for file in sorted(folder.iterdir()) if file.suffix.lower() in IMAGES]
    images = [file for file in other if file.suffix.lower() == suffix]
    strange = next((file for file in other if file not in images), None)
    if strange is not None:
        hint = "space=radiance reads EXR" if strange.suffix.lower() == ".exr" else "export PNG"
        raise UserError(f"{strange} is no {suffix} image, which these frames are said to be: {hint}, or remove it.")
    numbered: dict[int, Path] = {}
    for file in images:
        digits = re.search(r"(\d+)$", file.stem)
        if digits is None:
            raise UserError(f"{file} has no number at its name's end: name frames like frame_0000{suffix}.")
        number = int(digits[1])
        if number in numbered:
            raise UserError(f"{file} and {numbered[number].name} are the same frame: remove one of them.")
        numbered[number] = file
    first, last = min(numbered), max(numbered)
    gaps = [number for number in range(first, last + 1) if number not in numbered]
    if gaps:
        raise UserError(
            f"{folder} lacks frame {gaps[0]} of {first} to {last}: every frame has to be there; make it again."
        )
    if len(numbered) != frames:
        raise UserError(
            f"{folder} holds {len(numbered)} frames, its clip {frames}: upscale the clip from its first to its last frame."
        )
    return [numbered[number] for number in sorted(numbered)]
