"""The turntable: standing cameras, one slow object in the middle of every view, nothing else that moves."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.scenes.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("turntable")


def test_every_camera_stands(scene):
    assert len(scene.routes) == 10
    for route in scene.routes:
        assert route.recorded is not None
        first = route.recorded(0.0)
        for seconds in (0.5, 17.3, 60.0):
            np.testing.assert_array_equal(route.recorded(seconds), first)


def test_one_object_turns_slowly_in_the_middle_of_every_view(scene):
    (machine,) = [o for o in scene.objects if o.moves]
    points = np.concatenate([scene.meshes[m].positions for m in machine.meshes]).astype(float)
    assert len(np.concatenate([scene.meshes[m].triangles for m in machine.meshes])) > 20_000
    for route in scene.routes:
        world_to_camera = np.linalg.inv(route.recorded(0.0).astype(float))
        focal = 540.0 / np.tan(route.fov / 2)  # pixels of a 1080p frame
        pixels = []
        for seconds in (10.0, 10.0 + 1.0 / 60.0):
            pose = world_to_camera @ machine.at(seconds).astype(float)
            seen = points @ pose[:3, :3].T + pose[:3, 3]
            ahead = seen[:, 2] < -0.1
            pixels.append(focal * seen[:, :2] / -seen[:, 2:])
        moved = np.linalg.norm(pixels[1] - pixels[0], axis=1)[ahead]
        assert 0.5 < moved.max() < 6.0, route.name  # slow, yet more than half a pixel per frame
        inside = (np.abs(pixels[0][ahead]) < (960.0, 540.0)).all(axis=1)
        assert inside.mean() > 0.3, route.name
        centre = np.median(pixels[0][ahead][inside], axis=0)
        assert np.abs(centre[0]) < 200.0, route.name
