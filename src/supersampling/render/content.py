"""Scenes by name: the built-in ones and SuperTuxKart's tracks."""

from supersampling.errors import UserError
from supersampling.render.scene import Scene


def load_scene(name: str) -> Scene:
    """The scene called ``name``: a built-in one, or ``stk/<track>``.

    Raises:
        UserError: no such scene or track, or SuperTuxKart's data are not installed.
    """
    from supersampling.render.scenes import BUILT_IN
    from supersampling.render.stk import load_track

    kind, _, track = name.partition("/")
    if kind == "stk":
        return load_track(track)
    if name not in BUILT_IN:
        known = ", ".join(sorted(BUILT_IN))
        raise UserError(f"There is no scene {name}: use {known}, or stk/<track> for a SuperTuxKart track.")
    return BUILT_IN[name]()
