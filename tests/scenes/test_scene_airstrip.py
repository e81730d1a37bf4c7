"""The airstrip: fast objects on closed courses that cross every route's view again and again, all of it matt."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.scenes.airstrip.motion import lane
from supersampling.scenes.kit.course import Course
from supersampling.scenes.scene import Scene

FRAME = 1.0 / 60.0
FOCAL = 540.0 / np.tan(1.05 / 2)  # pixels of a 1080p frame


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("airstrip")


def test_every_route_sees_many_fast_crossings(scene):
    movers = [o for o in scene.objects if o.moves and len(o.meshes) > 1]  # without propellers, rotors, axles
    times = np.arange(0.0, 60.0, 0.3)
    now = np.array([[o.at(float(t))[:3, 3] for t in times] for o in movers], float)
    soon = np.array([[o.at(float(t) + FRAME)[:3, 3] for t in times] for o in movers], float)
    for route in scene.routes:
        eye, focus = np.mean(route.points, axis=0), np.mean(route.focus, axis=0)
        forward = (focus - eye) / np.linalg.norm(focus - eye)
        before, after = now - eye, soon - eye
        cosine = (before @ forward) / np.linalg.norm(before, axis=2)
        turn = np.cross(before, after)
        pixels = FOCAL * np.linalg.norm(turn, axis=2) / (before**2).sum(axis=2)
        ahead = cosine > np.cos(np.radians(35))
        fast = ahead & (pixels > 20)
        assert fast.any(axis=0).mean() > 0.3, route.name  # a third of the time some fast object is in view
        assert fast.any(axis=1).sum() >= 5, route.name
        assert (ahead & (pixels > 0.5) & (pixels < 6)).any(), route.name  # and a slow one now and then


def test_nothing_shines(scene):
    for material in scene.materials:
        rough = 255 if material.surface is None else material.surface[..., 0].min()
        assert material.roughness * rough / 255 >= 0.75, material.name
        assert material.metallic == 0.0
        assert max(material.emission) == 0.0


def test_course_is_walked_at_even_speed_along_its_nose():
    ride = lane(30.0, 16.0, 4.0, 5.0).ride(30.0, 0.2, 0.8)
    poses = np.stack([ride(k * FRAME) for k in range(400)]).astype(float)
    step = np.diff(poses[:, :3, 3], axis=0)
    np.testing.assert_allclose(np.linalg.norm(step, axis=1), 30.0 * FRAME, rtol=0.02)
    nose = (poses[:-1, :3, 0] + poses[1:, :3, 0]) / 2
    assert ((step * nose).sum(axis=1) / np.linalg.norm(step, axis=1)).min() > 0.999


def test_banks_into_the_bend():
    circle = np.linspace(0, 2 * np.pi, 25)[:-1]
    course = Course(np.stack([20 * np.cos(circle), 0 * circle + 5, -20 * np.sin(circle)], 1))
    assert course.length == pytest.approx(40 * np.pi, rel=1e-3)
    for speed in (25.0, -25.0):
        pose = course.ride(speed, 0.3, 0.8)(0.0)
        inward = -pose[:3, 3] * [1, 0, 1]
        assert pose[:3, 1] @ inward > 0.3 * np.linalg.norm(inward)  # the plane's up leans to the middle
