"""The files of a capture, checked: no path leaves the folder, no frame is missing, and JSON is valid."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from supersampling.errors import UserError

MAX_JSON = 64 << 20  # bytes
LARGEST = float(np.finfo(np.float32).max)
FOREIGN = ("__MACOSX", "@eaDir")  # folders that archives and network storage add, beside hidden ones


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
        try:
            real = path.resolve()
        # A symbolic link that leads back to itself.
        except (OSError, RuntimeError) as error:
            raise UserError(f"{path} cannot be followed ({error}): copy the file into the folder.") from error
        if not real.is_relative_to(self.path):
            raise UserError(f"{path} leads out of the capture folder to {real}: copy the file into the folder.")
        return path

    def folders(self, *parts: str) -> list[str]:
        """Return the sorted names of the folders in a folder; none if it does not exist."""
        entries = self._entries(self.inside(*parts))
        names = (entry.name for entry in entries if entry.is_dir())
        return [name for name in names if not name.startswith(".") and name not in FOREIGN]

    @staticmethod
    def _entries(folder: Path) -> list[Path]:
        """Return the sorted content of a folder; nothing if it does not exist."""
        try:
            return sorted(folder.iterdir())
        except (FileNotFoundError, NotADirectoryError):
            return []
        except OSError as error:
            raise UserError(f"{folder} cannot be listed ({error.strerror}): correct its permissions.") from error

    def frames(self, folder: Path, suffix: str) -> "Frames":
        """Return the files ``<number><suffix>`` of a folder by their number, with any padding by zeros and any case.

        Raises:
            UserError: the folder is missing or has no such file, or two files have the same number.
        """
        folder = self.inside(folder)
        files: dict[int, Path] = {}
        for file in self._entries(folder):
            if file.suffix.lower() == suffix and file.stem.isascii() and file.stem.isdigit():
                if int(file.stem) in files:
                    raise UserError(
                        f"{file} and {files[int(file.stem)].name} are the same frame: move one of them elsewhere."
                    )
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
        return json.loads(path.read_text(encoding="utf-8-sig"), object_pairs_hook=_unique)
    except FileNotFoundError as error:
        raise UserError(f"{path} is missing: restore it.") from error
    except OSError as error:
        raise UserError(f"{path} cannot be read ({error.strerror}): correct the path or its permissions.") from error
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path} is not valid JSON ({error}): restore it.") from error


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object; raise `ValueError` if it states a key twice, since either value may be meant."""
    content = dict(pairs)
    if len(content) < len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"the key {next(key for key in keys if keys.count(key) > 1)} occurs twice in an object")
    return content


def number(mapping: Any, key: str, path: Path) -> float:
    """Return a finite number of a JSON object.

    Raises:
        UserError: the value is missing or not a finite number; the message names the file and the key.
    """
    value = mapping.get(key) if isinstance(mapping, dict) else None
    # Python reads numbers of any size.
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -LARGEST <= value <= LARGEST:
        raise UserError(f"Invalid {key} in {path} ({str(value)[:40]!r}): write a finite number.")
    return float(value)
