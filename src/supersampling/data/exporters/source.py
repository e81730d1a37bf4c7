"""What the writers read: the frames of one clip of a data set file."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.readers.images import Image
from supersampling.errors import UserError


def check_exportable(store: DatasetFile, needed: frozenset[str], layout: str) -> None:
    """Raises `UserError` for a file that lacks buffers, or targets of some frames."""
    missing = sorted(needed - store.buffers)
    if missing:
        raise UserError(
            f"{store.path} lacks {', '.join(missing)}, which the layout {layout} has: add them with "
            f"render.py data.buffers=[{','.join(sorted(needed))}]."
        )
    spec = store.spec
    if spec.targets != spec.frames:
        raise UserError(
            f"{store.path} has targets for the last {spec.targets} of {spec.frames} frames, a capture for all: render it with "
            f"data.{spec.split}.targets={spec.frames}."
        )


def read_frames(store: DatasetFile, clip: int, needed: frozenset[str]) -> Iterator[dict[str, Image]]:
    """The frames of a clip, one at a time: buffers ``(h, w, C)``, jitter ``(2,)``."""
    for t in range(store.spec.frames):
        frame = {}
        for name in sorted(needed):
            values = store.read(name, clip, slice(t, t + 1))[0]
            frame[name] = values if values.ndim == 1 else np.ascontiguousarray(values.transpose(1, 2, 0))
        yield frame


def scene_name(store: DatasetFile) -> str:
    """The scene as a folder's name."""
    last = store.spec.scene.rsplit("/", 1)[-1]
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in last) or "Scene"


def empty_folder(path: Path) -> Path:
    """``path``, made if need be; raises `UserError` where it holds something already, which a capture could be mixed with."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        if any(path.iterdir()):
            raise UserError(f"{path} is not empty: export into a new folder.")
    except OSError as error:
        raise UserError(f"Cannot make the folder {path}: {error.strerror}; export into another one.") from error
    return path
