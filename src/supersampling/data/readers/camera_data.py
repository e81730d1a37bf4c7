"""Reader of QRISP's jitter: annex A.2 has one JSON per segment, the files in circulation one per frame; both are
read."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from supersampling.data.readers.files import Root, number, read_json
from supersampling.data.readers.images import Image
from supersampling.errors import UserError

KEY = "jitter_offset"


class Jitters:
    """The jitter of each frame of a segment, as stored.

    Raises:
        UserError: the camera data or the jitter of a frame is missing.
    """

    def __init__(self, root: Root, folder: Path, segment: str, numbers: list[int]) -> None:
        self._entries: dict[int, tuple[Path, Any]] = {}
        single = root.inside(folder / f"{segment}.json")
        if single.is_file():
            entries = _by_number(single, numbers)
            self._entries = {k: (single, entries[k]) for k in numbers}
            return
        frames = root.frames(folder / segment, ".json")
        if len(numbers) > 1 and len(frames.files) == 1:
            path = next(iter(frames.files.values()))
            entries = _by_number(path, numbers)
            self._entries = {k: (path, entries[k]) for k in numbers}
            return
        for k in numbers:
            if k not in frames.files:
                raise UserError(
                    f"{frames.folder / f'{k:04d}.json'} is missing: restore it, inputs without jitter cannot be used."
                )
        self._entries = {k: (frames[k], None) for k in numbers}

    def files(self) -> Iterable[Path]:
        yield from dict.fromkeys(path for path, _ in self._entries.values())

    def read(self, frame: int) -> tuple[Image, Path]:
        """Return the stored pair ``(2,)`` and its file."""
        path, entry = self._entries[frame]
        content = read_json(path) if entry is None else entry
        return _pair(content, path, frame), path


def _by_number(path: Path, numbers: list[int]) -> dict[int, Any]:
    """Return the entries of a segment's JSON by frame number.

    The JSON is a list in order or an object by frame name, which may be the value of the key ``frames``.
    """
    content = read_json(path)
    if isinstance(content, dict):
        content = next((v for k, v in content.items() if k.lower() == "frames"), content)
    if isinstance(content, list):
        if len(content) != len(numbers):
            raise UserError(f"{path} has {len(content)} entries for {len(numbers)} frames: restore it.")
        return dict(zip(numbers, content))
    named = {int(k): v for k, v in content.items() if k.isascii() and k.isdigit()} if isinstance(content, dict) else {}
    for k in numbers:
        if k not in named:
            raise UserError(f"{path} has no {KEY} for frame {k:04d}: restore it.")
    return named


def _pair(entry: Any, path: Path, frame: int) -> Image:
    offset = entry.get(KEY) if isinstance(entry, dict) else None
    if not isinstance(offset, dict):
        raise UserError(
            f"{path} has no {KEY} with x and y for frame {frame:04d}: restore it, inputs without jitter cannot be used."
        )
    return np.array((number(offset, "x", path), number(offset, "y", path)), dtype=np.float32)
