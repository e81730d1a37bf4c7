"""The files of a capture: no path may leave its folder, no frame may be missing, no JSON may surprise."""

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
        UserError: there is no such folder.
    """

    def __init__(self, path: Path) -> None:
        if not path.is_dir():
            raise UserError(f"There is no capture folder {path}: correct path=.")
        self.path = path.resolve()

    @property
    def name(self) -> str:
        return self.path.name

    def inside(self, *parts: str | Path) -> Path:
        """A path below the folder, links followed.

        Raises:
            UserError: it leaves the folder, through ``..`` or a symbolic link.
        """
        path = self.path.joinpath(*parts)
        real = path.resolve()
        if not real.is_relative_to(self.path):
            raise UserError(
                f"{path} leads out of the capture folder to {real}: a capture may only read files of its own; copy them there."
            )
        return path

    def folders(self, *parts: str) -> list[str]:
        """Names of the folders in a folder, sorted; none where it is missing."""
        folder = self.inside(*parts)
        if not folder.is_dir():
            return []
        return sorted(entry.name for entry in folder.iterdir() if entry.is_dir())

    def frames(self, folder: Path, suffix: str) -> "Frames":
        """The files ``<number><suffix>`` of a folder by their number, whatever zeros they are padded with.

        Raises:
            UserError: the folder is missing or empty, or a number comes twice.
        """
        folder = self.inside(folder)
        found: dict[int, Path] = {}
        for file in sorted(folder.iterdir()) if folder.is_dir() else []:
            if file.suffix == suffix and file.stem.isascii() and file.stem.isdigit():
                if int(file.stem) in found:
                    raise UserError(f"{file} and {found[int(file.stem)].name} are the same frame: remove one of them.")
                found[int(file.stem)] = self.inside(file)
        if not found:
            raise UserError(
                f"{folder} holds no frames named <number>{suffix}: unpack this part of the capture as well."
            )
        return Frames(folder, suffix, found)


@dataclass(frozen=True)
class Frames:
    """One buffer's files of a clip, by frame number."""

    folder: Path
    suffix: str
    files: Mapping[int, Path]

    def __getitem__(self, number: int) -> Path:
        return self.files[number]


def frame_numbers(streams: Mapping[str, Frames]) -> list[int]:
    """The frame numbers of a clip, of which every buffer must have every one.

    Raises:
        UserError: names the first file that is missing.
    """
    first = min(min(s.files) for s in streams.values())
    last = max(max(s.files) for s in streams.values())
    for number in range(first, last + 1):
        for stream in streams.values():
            if number not in stream.files:
                width = len(next(iter(stream.files.values())).stem)
                missing = stream.folder / f"{number:0{width}d}{stream.suffix}"
                raise UserError(f"{missing} is missing: frames {first} to {last} must all be there; restore it.")
    return list(range(first, last + 1))


def read_json(path: Path) -> Any:
    """The content of a JSON file.

    Raises:
        UserError: it is missing, larger than any capture's, or not JSON.
    """
    try:
        if path.stat().st_size > MAX_JSON:
            raise UserError(
                f"{path} has more than {MAX_JSON} bytes, too many for a capture's JSON: check where it is from."
            )
        return json.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError as error:
        raise UserError(f"{path} is missing: restore it.") from error
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path} is not valid JSON ({error}): restore it.") from error


def number(mapping: Any, key: str, path: Path) -> float:
    """A finite number of a JSON object.

    Raises:
        UserError: names the file and the key.
    """
    value = mapping.get(key) if isinstance(mapping, dict) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UserError(f"{path} has no finite number {key!r} where one belongs (found {value!r}): correct it.")
    return float(value)
