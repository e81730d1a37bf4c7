"""Where SuperTuxKart's data lie, and which file a track means by a name."""

import os
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from supersampling.errors import UserError

DATA_VARIABLE = "SUPERTUXKART_DATADIR"
_DEBIAN = Path("/usr/share/games/supertuxkart/data")
_INSTALL = "apt-get install supertuxkart-data (628 MB)"


def find_data() -> Path | None:
    """SuperTuxKart's data folder: ``$SUPERTUXKART_DATADIR`` where it is set, else Debian's; ``None`` without one."""
    named = os.environ.get(DATA_VARIABLE)
    if named:
        candidates = [Path(named), Path(named) / "data"]
    else:
        candidates = [_DEBIAN]
    return next((folder for folder in candidates if (folder / "tracks").is_dir()), None)


def data_folder(root: Path | None) -> Path:
    """``root``, or the installed data folder.

    Raises:
        UserError: there is no ``tracks`` folder in it, or nothing is installed.
    """
    found = find_data() if root is None else root
    if found is None and os.environ.get(DATA_VARIABLE):
        raise UserError(
            f"{DATA_VARIABLE}={os.environ[DATA_VARIABLE]} holds no tracks folder: set it to SuperTuxKart's data folder, "
            f"or unset it and {_INSTALL}."
        )
    if found is None:
        raise UserError(
            f"SuperTuxKart's data are not installed: {_INSTALL}, or set {DATA_VARIABLE} to the data folder."
        )
    if not (found / "tracks").is_dir():
        raise UserError(f"{found} holds no tracks folder: name SuperTuxKart's data folder, or {_INSTALL}.")
    return found


def available_tracks(root: Path | None = None) -> list[str]:
    """Names of the tracks that can be loaded: those with a scene and a driveline or a navigation mesh."""
    return [
        folder.name
        for folder in sorted((data_folder(root) / "tracks").iterdir())
        if (folder / "scene.xml").is_file() and ((folder / "quads.xml").is_file() or (folder / "navmesh.xml").is_file())
    ]


def track_folder(name: str, root: Path | None) -> Path:
    """The folder of the track called ``name``.

    Raises:
        UserError: there is no such track; the sentence names those that come close.
    """
    known = available_tracks(root)
    if name not in known:
        close = get_close_matches(name, known, n=3)
        hint = f"did you mean {', '.join(close)}?" if close else f"the tracks are {', '.join(known)}."
        raise UserError(f"There is no SuperTuxKart track {name}: {hint}")
    return data_folder(root) / "tracks" / name


def inside(folder: Path, name: str) -> Path | None:
    """``folder / name`` when it is a file and does not lead out of ``folder``."""
    if not name or Path(name).is_absolute() or ".." in Path(name).parts:
        return None
    path = folder / name
    return path if path.is_file() else None


@dataclass(frozen=True)
class Assets:
    """Finds models, textures and library nodes as the game does: beside their user, in the track, then in the data."""

    root: Path
    track: Path

    def model(self, name: str, folder: Path) -> Path | None:
        return self._first(name, (folder, self.track, self.root / "models"))

    def texture(self, name: str, folder: Path) -> Path | None:
        shared = self.root / "textures"
        return self._first(name, (folder, self.track, shared, shared / "skybox"))

    def library(self, name: str) -> Path | None:
        """The ``node.xml`` of a library node."""
        return self._first(f"{name}/node.xml", (self.track / "library", self.root / "library"))

    @staticmethod
    def _first(name: str, folders: tuple[Path, ...]) -> Path | None:
        return next((path for folder in folders if (path := inside(folder, name))), None)
