"""Locations of SuperTuxKart's data, and of the files that a track refers to by name."""

import os
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from supersampling.errors import UserError

DATA_VARIABLE = "SUPERTUXKART_DATADIR"
_DEBIAN = Path("/usr/share/games/supertuxkart/data")
_INSTALL = "apt-get install supertuxkart-data (628 MB)"


def find_data() -> Path | None:
    """Return SuperTuxKart's data folder: ``$SUPERTUXKART_DATADIR`` if it is set, else Debian's; None if not found."""
    configured = os.environ.get(DATA_VARIABLE)
    if configured:
        candidates = [Path(configured), Path(configured) / "data"]
    else:
        candidates = [_DEBIAN]
    return next((folder for folder in candidates if (folder / "tracks").is_dir()), None)


def data_folder(root: Path | None) -> Path:
    """Return ``root``, or the installed data folder.

    Raises:
        UserError: The folder has no ``tracks`` folder, or no data are installed.
    """
    folder = find_data() if root is None else root
    if folder is None and os.environ.get(DATA_VARIABLE):
        raise UserError(
            f"{DATA_VARIABLE}={os.environ[DATA_VARIABLE]} has no tracks folder: set it to SuperTuxKart's data folder, "
            f"or unset it and {_INSTALL}."
        )
    if folder is None:
        raise UserError(
            f"SuperTuxKart's data are not installed: {_INSTALL}, or set {DATA_VARIABLE} to the data folder."
        )
    if not (folder / "tracks").is_dir():
        raise UserError(f"{folder} has no tracks folder: use SuperTuxKart's data folder, or {_INSTALL}.")
    return folder


def available_tracks(root: Path | None = None) -> list[str]:
    """Return the names of the loadable tracks: those with a scene and a driveline or a navigation mesh."""
    return [
        folder.name
        for folder in sorted((data_folder(root) / "tracks").iterdir())
        if (folder / "scene.xml").is_file() and ((folder / "quads.xml").is_file() or (folder / "navmesh.xml").is_file())
    ]


def track_folder(name: str, root: Path | None) -> Path:
    """Return the folder of the track called ``name``.

    Raises:
        UserError: The track does not exist; the message names similar ones.
    """
    known = available_tracks(root)
    if name not in known:
        close = get_close_matches(name, known, n=3)
        hint = f"did you mean {', '.join(close)}?" if close else f"use one of {', '.join(known)}."
        raise UserError(f"Unknown SuperTuxKart track {name}: {hint}")
    return data_folder(root) / "tracks" / name


def inside(folder: Path, name: str) -> Path | None:
    """Return ``folder / name`` if it is a file and inside ``folder``, else None."""
    if not name or Path(name).is_absolute() or ".." in Path(name).parts:
        return None
    path = folder / name
    return path if path.is_file() else None


@dataclass(frozen=True)
class Assets:
    """Search paths of models, textures and library nodes, as in the game: beside the user, the track, the data."""

    root: Path
    track: Path

    def model(self, name: str, folder: Path) -> Path | None:
        return self._first(name, (folder, self.track, self.root / "models"))

    def texture(self, name: str, folder: Path) -> Path | None:
        shared = self.root / "textures"
        return self._first(name, (folder, self.track, shared, shared / "skybox"))

    def library(self, name: str) -> Path | None:
        """Return the ``node.xml`` of a library node."""
        return self._first(f"{name}/node.xml", (self.track / "library", self.root / "library"))

    @staticmethod
    def _first(name: str, folders: tuple[Path, ...]) -> Path | None:
        return next((path for folder in folders if (path := inside(folder, name))), None)
