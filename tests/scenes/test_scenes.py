"""Every built-in scene is sound, moves smoothly, leaves its routes free and is built equally each time."""

import pytest
from built_scenes import built
from scene_checks import check_equal, check_meshes, check_motion, check_routes

from supersampling.scenes.built_in import BUILT_IN

LARGE = {"atrium": (88_000, 25e6), "foundry": (100_002, 25e6)}  # triangles, texels


@pytest.mark.parametrize("name", BUILT_IN)
def test_meshes(name):
    check_meshes(built(name), *LARGE.get(name, ()))


@pytest.mark.parametrize("name", BUILT_IN)
def test_motion(name):
    check_motion(built(name))


@pytest.mark.parametrize("name", BUILT_IN)
def test_routes(name):
    check_routes(built(name))


@pytest.mark.parametrize("name", BUILT_IN)
def test_two_builds_are_equal(name):
    check_equal(built(name), BUILT_IN[name]())
