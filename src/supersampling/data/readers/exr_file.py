"""The library that decodes EXR: headers as records, channels as arrays, each of its errors as one sentence."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import OpenEXR
from numpy.typing import NDArray

from supersampling.data.readers.images import check_readable
from supersampling.errors import UserError

DEEP = (OpenEXR.deepscanline, OpenEXR.deeptile)

T = TypeVar("T")


class ExrWindow(NamedTuple):
    """The first and the last pixel of a rectangle."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def size(self) -> tuple[int, int]:
        return self.right - self.left + 1, self.bottom - self.top + 1

    def covers(self, window: "ExrWindow") -> bool:
        """Return whether each pixel of a window lies in this one."""
        before = self.left <= window.left and self.top <= window.top
        return before and self.right >= window.right and self.bottom >= window.bottom

    def __str__(self) -> str:
        return f"{self.left},{self.top} to {self.right},{self.bottom}"


class ExrPart(NamedTuple):
    """The header of a part."""

    name: str
    sampling: Mapping[str, tuple[int, int]]
    """The steps in x and y between the pixels that are stored, by channel."""
    data: ExrWindow
    display: ExrWindow
    deep: bool
    attributes: Mapping[str, Any]


def read_parts(path: Path) -> list[ExrPart]:
    """Return the headers of a file.

    Raises:
        UserError: the file is missing, cannot be opened, is damaged, or is not EXR.
    """

    def read() -> list[ExrPart]:
        file = OpenEXR.File(str(path), separate_channels=True, header_only=True)
        return [_part(file.header(k)) for k in range(len(file.parts))]

    parts = _decode(path, read)
    if not parts:
        raise UserError(f"{path} is truncated or damaged (it has no parts): restore it.")
    return parts


def read_channels(path: Path, part: int, names: Sequence[str]) -> list[NDArray[Any]]:
    """Return channels of a part, ``(h, w)`` each, in the order of ``names``; errors as in `read_parts`."""

    def read() -> list[NDArray[Any]]:
        # The library leaves out parts that it cannot read: their place in the list is not their number.
        parts = {item.part_index: item for item in OpenEXR.File(str(path), separate_channels=True).parts}
        if part not in parts:
            raise UserError(f"{path} is truncated or damaged (part {part} cannot be read): restore it.")
        channels = parts[part].channels
        return [channels[name].pixels for name in names]

    return _decode(path, read)


def _part(header: Mapping[str, Any]) -> ExrPart:
    return ExrPart(
        str(header.get("name", "")),
        {c.name: (c.xSampling, c.ySampling) for c in header["channels"]},
        _window(header["dataWindow"]),
        _window(header["displayWindow"]),
        header.get("type") in DEEP,
        header,
    )


def _window(corners: tuple[Any, Any]) -> ExrWindow:
    first, last = corners
    return ExrWindow(*(int(n) for n in (*first, *last)))


def _decode(path: Path, read: Callable[[], T]) -> T:
    check_readable(path)
    try:
        return read()
    except KeyError as error:
        raise UserError(f"{path} is truncated or damaged ({error} cannot be read): restore it.") from error
    except (ValueError, RuntimeError, TypeError) as error:
        raise UserError(f"{path} is truncated or not an EXR image ({error}): restore it.") from error
