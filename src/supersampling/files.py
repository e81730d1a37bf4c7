"""Files that are replaced whole or not at all, and names that are no files."""

import os
import sys
from pathlib import Path

from supersampling.errors import DamagedFile, UserError


def check_regular_file(path: Path) -> None:
    """Raise `UserError` for a folder, a link to a missing file, or a pipe, which would be waited for without end."""
    if path.is_symlink() and not path.exists():
        raise UserError(f"{path} is a link to {path.readlink()}, which does not exist: correct the link.")
    if path.exists() and not path.is_file():
        kind = "a folder" if path.is_dir() else "a device or a pipe"
        raise UserError(f"{path} is {kind}: name a file.")


def replace_file(temporary: Path, path: Path) -> None:
    """Rename a file that is written completely to ``path``; after a crash of the machine, the file is whole."""
    with temporary.open("rb") as file:
        os.fsync(file.fileno())
    temporary.replace(path)


def set_aside(path: Path, error: DamagedFile, consequence: str) -> None:
    """Rename a broken file to ``NAME.broken``, and print its fault and the ``consequence``."""
    place = path.with_name(f"{path.name}.broken")
    path.replace(place)
    sys.stderr.write(f"{error.reason}: it is now {place.name}, and {consequence}.\n")
