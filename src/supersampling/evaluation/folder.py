"""Search for frames that another program upscaled, clip by clip.

``FOLDER/<scene>/<clip>/<anything><number>.<suffix>``; ``<clip>`` counts from 0. A level with a single entry may be left
out: the frames of a single clip may be in the folder itself. A ``/`` in the name of a scene is a folder or ``_``.
"""

import re
from collections.abc import Sequence
from pathlib import Path

from supersampling.data.dataset_file import read_spec
from supersampling.errors import UserError
from supersampling.evaluation.crops import file_name

IMAGES = (".png", ".exr", ".jpg", ".jpeg", ".hdr", ".tif", ".tiff", ".bmp", ".webp", ".tga")


def clip_files(folder: Path, files: Sequence[Path], suffix: str) -> list[list[Path]]:
    """Return the frames ``*<suffix>`` of every clip of these data set files, in their order.

    Raises:
        UserError: the folder does not exist, or a clip has no frames, frames of a different format, missing frames, too
            many frames, or the same frame twice.
    """
    if not folder.is_dir():
        raise UserError(f"Folder {folder} not found: correct frames=.")
    specs = [read_spec(path) for path in files]
    return [
        _clip(_folder(folder, spec.scene, clip, len(specs) == 1, spec.clips == 1), suffix, spec.frames)
        for spec in specs
        for clip in range(spec.clips)
    ]


def _folder(folder: Path, scene: str, clip: int, single_scene: bool, single_clip: bool) -> Path:
    scenes = [folder / scene, folder / file_name(scene), *([folder] if single_scene else [])]
    candidates = [path / str(clip) for path in scenes] + (scenes if single_clip else [])
    for path in candidates:
        if path.is_dir() and any(file.suffix.lower() in IMAGES for file in path.iterdir()):
            return path
    raise UserError(f"Clip {clip} of {scene} has no frames: put them into {' or '.join(map(str, candidates))}.")


def _clip(folder: Path, suffix: str, frames: int) -> list[Path]:
    images = [file for file in sorted(folder.iterdir()) if file.suffix.lower() in IMAGES]
    mismatch = next((file for file in images if file.suffix.lower() != suffix), None)
    if mismatch is not None:
        hint = "set space=radiance for EXR" if mismatch.suffix.lower() == ".exr" else f"export {suffix} images"
        raise UserError(f"{mismatch} is not a {suffix} image, as the setting space requires: {hint}, or move it away.")
    numbered: dict[int, Path] = {}
    for file in images:
        digits = re.search(r"(\d+)$", file.stem)
        if digits is None:
            raise UserError(f"{file} has no number at the end of its name: name frames like frame_0000{suffix}.")
        number = int(digits[1])
        if number in numbered:
            raise UserError(f"{file} and {numbered[number].name} are the same frame: remove one of them.")
        numbered[number] = file
    first, last = min(numbered), max(numbered)
    gaps = [number for number in range(first, last + 1) if number not in numbered]
    if gaps:
        raise UserError(
            f"{folder} has no frame {gaps[0]} of {first} to {last}: upscale the clip again, every frame is required."
        )
    if len(numbered) != frames:
        raise UserError(
            f"{folder} has {len(numbered)} frames, but the clip has {frames}: upscale it from its first to its last "
            "frame."
        )
    return [numbered[number] for number in sorted(numbered)]
