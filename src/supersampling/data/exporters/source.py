"""The input of the writers: the frames of one clip of a data set file."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.readers.images import Image
from supersampling.errors import UserError


def check_exportable(file: DatasetFile, required: frozenset[str], layout: str) -> None:
    """Raise `UserError` if buffers, or targets of some frames, are missing."""
    missing = sorted(required - file.buffers)
    if missing:
        raise UserError(
            f"{file.path} has no {', '.join(missing)}, which the layout {layout} requires: add them with "
            f"render.py data.buffers=[{','.join(sorted(required))}]."
        )
    spec = file.spec
    if spec.targets != spec.frames:
        raise UserError(
            f"{file.path} has targets for the last {spec.targets} of {spec.frames} frames only: render it with "
            f"data.{spec.split}.targets={spec.frames}."
        )


def read_frames(file: DatasetFile, clip: int, names: frozenset[str]) -> Iterator[dict[str, Image]]:
    """Yield the frames of a clip one at a time: buffers ``(h, w, C)``, jitter ``(2,)``."""
    for t in range(file.spec.frames):
        frame = {}
        for name in sorted(names):
            values = file.read(name, clip, slice(t, t + 1))[0]
            frame[name] = values if values.ndim == 1 else np.ascontiguousarray(values.transpose(1, 2, 0))
        yield frame


def scene_name(file: DatasetFile) -> str:
    """Return the scene's name as the name of a folder."""
    last = file.spec.scene.rsplit("/", 1)[-1]
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in last) or "Scene"


def empty_folder(path: Path) -> Path:
    """Return the folder ``path``, created if necessary; raise `UserError` if it is not empty, to avoid mixing
    captures."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        if any(path.iterdir()):
            raise UserError(f"{path} is not empty: export into a new folder.")
    except OSError as error:
        raise UserError(f"Cannot create the folder {path} ({error.strerror}): export into another folder.") from error
    return path
