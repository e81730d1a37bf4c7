"""Scenes by name: the built-in ones, SuperTuxKart's tracks, and a user's own glTF file."""

from pathlib import Path

from supersampling.errors import UserError
from supersampling.scenes.scene import Scene


def check_scene(name: str) -> None:
    """Raise `UserError` if the scene does not exist, without building it.

    Raises:
        UserError: the scene or track does not exist, or SuperTuxKart's data are not installed.
    """
    kind, _, rest = name.partition("/")
    if kind == "gltf" and rest:
        return  # its file was read when its fingerprint was taken
    if kind == "stk":
        from supersampling.scenes.stk import track_folder

        track_folder(rest, None)
        return
    from supersampling.scenes.built_in import BUILT_IN

    if name not in BUILT_IN:
        known = ", ".join(sorted(BUILT_IN))
        raise UserError(
            f"Unknown scene {name}: use {known}, stk/<track> for a SuperTuxKart track, or scene=gltf path=FILE."
        )


def load_scene(name: str, path: Path | None = None) -> Scene:
    """Return the scene ``name``: a built-in one, ``stk/<track>``, or ``gltf/<stem>`` from the glTF file ``path``.

    Raises:
        UserError: the scene or track does not exist, SuperTuxKart's data are not installed, or the file cannot be read.
    """
    check_scene(name)
    kind, _, rest = name.partition("/")
    if kind == "gltf":
        from supersampling.scenes.gltf import load_gltf

        if path is None:
            raise UserError("Missing path for scene=gltf: add path=FILE.gltf or path=FILE.glb.")
        return load_gltf(path)
    if kind == "stk":
        from supersampling.scenes.stk import load_track

        return load_track(rest)
    from supersampling.scenes.built_in import BUILT_IN

    return BUILT_IN[name]()


def installed_scenes() -> list[str]:
    """Return the default scenes: atrium, foundry, and two SuperTuxKart tracks if their data are installed."""
    from supersampling.scenes.stk import find_data

    tracks = ["stk/zengarden", "stk/black_forest"] if find_data() else []
    return ["atrium", "foundry", *tracks]
