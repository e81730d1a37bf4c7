"""The files of a capture, checked: no path leaves the folder, no frame is missing, and JSON is valid."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from supersampling.errors import UserError

MAX_JSON = 64 << 20  # bytes


class Root:
    """A capture's folder.

    Raises:
        UserError: the folder does not exist.
    """

    def __init__(self, path: Path) -> None:
        if not path.is_dir():
            raise UserError(f"Capture folder {path} not found: correct path=.")
        self.path = path.resolve()

    @property
    def name(self) -> str:
        return self.path.name

    def inside(self, *parts: str | Path) -> Path:
        """Return a path below the folder.

        Raises:
            UserError: the path leaves the folder, through ``..`` or a symbolic link.
        """
        path = self.path.joinpath(*parts)
        real = path.resolve()
        if not real.is_relative_to(self.path):
            raise UserError(f"{path} leads out of the capture folder to {real}: copy the file into the folder.")
        return path

    def folders(self, *parts: str) -> list[str]:
        """Return the sorted names of the folders in a folder; none if it does not exist."""
        folder = self.inside(*parts)
        if not folder.is_dir():
            return []
        return sorted(entry.name for entry in folder.iterdir() if entry.is_dir())

    def frames(self, folder: Path, suffix: str) -> "Frames":
        """Return the files ``<number><suffix>`` of a folder by their number, with any padding by zeros.

        Raises:
            UserError: the folder is missing or has no such file, or two files have the same number.
        """
        folder = self.inside(folder)
        files: dict[int, Path] = {}
        for file in sorted(folder.iterdir()) if folder.is_dir() else []:
            if file.suffix == suffix and file.stem.isascii() and file.stem.isdigit():
                if int(file.stem) in files:
                    raise UserError(f"{file} and {files[int(file.stem)].name} are the same frame: remove one of them.")
                files[int(file.stem)] = self.inside(file)
        if not files:
            raise UserError(f"{folder} has no frames named <number>{suffix}: unpack this part of the capture as well.")
        return Frames(folder, suffix, files)


@dataclass(frozen=True)
class Frames:
    """The files of one buffer of a clip, by frame number."""

    folder: Path
    suffix: str
    files: Mapping[int, Path]

    def __getitem__(self, number: int) -> Path:
        return self.files[number]


def frame_numbers(streams: Mapping[str, Frames]) -> list[int]:
    """Return the frame numbers of a clip, from its first to its last frame.

    Raises:
        UserError: a frame of a buffer is missing; the message names the first such file.
    """
    first = min(min(s.files) for s in streams.values())
    last = max(max(s.files) for s in streams.values())
    for number in range(first, last + 1):
        for stream in streams.values():
            if number not in stream.files:
                width = len(next(iter(stream.files.values())).stem)
                missing = stream.folder / f"{number:0{width}d}{stream.suffix}"
                raise UserError(f"{missing} is missing: restore it, all frames from {first} to {last} are required.")
    return list(range(first, last + 1))


def read_json(path: Path) -> Any:
    """Return the content of a JSON file.

    Raises:
        UserError: the file is missing, larger than that of any capture, or not JSON.
    """
    try:
        if path.stat().st_size > MAX_JSON:
            raise UserError(f"{path} has more than {MAX_JSON} bytes, too many for a capture's JSON: check its origin.")
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError as error:
        raise UserError(f"{path} is missing: restore it.") from error
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path} is not valid JSON ({error}): restore it.") from error


def number(mapping: Any, key: str, path: Path) -> float:
    """Return a finite number of a JSON object.

    Raises:
        UserError: the value is missing or not a finite number; the message names the file and the key.
    """
    value = mapping.get(key) if isinstance(mapping, dict) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UserError(f"Invalid {key} in {path} ({value!r}): write a finite number.")
    return float(value)
