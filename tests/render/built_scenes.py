"""Built-in scenes, each made once a test process."""

from functools import cache

from supersampling.render.scene import Scene
from supersampling.render.scenes import BUILT_IN


@cache
def built(name: str) -> Scene:
    return BUILT_IN[name]()
