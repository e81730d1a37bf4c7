"""Built-in scenes, each built once per test process."""

from functools import cache

from supersampling.scenes.built_in import BUILT_IN
from supersampling.scenes.scene import Scene


@cache
def built(name: str) -> Scene:
    return BUILT_IN[name]()
