"""Scenes by name: the built-in ones and SuperTuxKart's tracks."""

from supersampling.errors import UserError
from supersampling.render.scene import Scene


def check_scene(name: str) -> None:
    """Refuse a scene that there is not, without making it.

    Raises:
        UserError: no such scene or track, or SuperTuxKart's data are not installed.
    """
    kind, _, track = name.partition("/")
    if kind == "stk":
        from supersampling.render.stk import track_folder

        track_folder(track, None)
        return
    from supersampling.render.scenes import BUILT_IN

    if name not in BUILT_IN:
        known = ", ".join(sorted(BUILT_IN))
        raise UserError(f"There is no scene {name}: use {known}, or stk/<track> for a SuperTuxKart track.")


def load_scene(name: str) -> Scene:
    """The scene called ``name``: a built-in one, or ``stk/<track>``.

    Raises:
        UserError: no such scene or track, or SuperTuxKart's data are not installed.
    """
    kind, _, track = name.partition("/")
    if kind == "stk":
        from supersampling.render.stk import load_track

        return load_track(track)
    from supersampling.render.scenes import BUILT_IN

    check_scene(name)
    return BUILT_IN[name]()
