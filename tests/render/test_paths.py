import numpy as np
import pytest
from camera_measures import ROUTE, STYLES, eyes, path

from supersampling.render.paths import rolled, split_routes
from supersampling.scenes.scene import Route, Scene, look_at


def test_look_at_puts_the_target_on_the_axis():
    eye, forward = np.array((1.0, 2.0, 3.0)), np.array((0.3, -0.1, -0.8))
    view = look_at(eye, forward)
    ahead = view @ np.append(eye + 2.5 * forward, 1.0)
    np.testing.assert_allclose(ahead[:2], 0.0, atol=1e-12)
    assert ahead[2] < 0
    np.testing.assert_allclose(view[:3, :3] @ view[:3, :3].T, np.eye(3), atol=1e-12)
    assert (view[:3, :3] @ (0, 1, 0))[1] > 0
    assert np.linalg.det(view[:3, :3]) == pytest.approx(1.0)


def test_a_camera_that_rolls_clockwise_sees_the_world_turn_the_other_way():
    view = rolled(look_at(np.zeros(3), np.array((0.0, 0.0, -1.0))), np.pi / 2)
    np.testing.assert_allclose(view[:3, :3] @ (0, 1, 0), (-1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(view[:3, :3] @ (0, 0, -1), (0, 0, -1), atol=1e-12)


def orbit(t: float) -> np.ndarray:
    """Camera-to-world: on a circle of radius 2 at height 1, looking at its centre."""
    c, s = np.cos(t), np.sin(t)
    return np.array(((s, 0, c, 2 * c), (0, 1, 0, 1), (-c, 0, s, 2 * s), (0, 0, 0, 1)), dtype=np.float32)


@pytest.mark.parametrize("style", STYLES)
def test_a_recorded_camera_is_followed_whatever_the_style(style):
    p = path(style, 3, 20, Route("orbit", ROUTE.points, recorded=orbit, fov=0.5))
    t = np.array(p.seconds)
    assert 0 <= t[0] < 60
    expected = np.stack((2 * np.cos(t), np.ones(20), 2 * np.sin(t)), axis=1)
    np.testing.assert_allclose(eyes(p), expected, atol=1e-6)
    for camera in p.cameras:
        centre = camera.view @ (0, 1, 0, 1)
        np.testing.assert_allclose(centre[:3], (0, 0, -2), atol=1e-6)
        assert camera.fov == 0.5


def test_a_recorded_camera_s_scale_does_not_count():
    def scaled(t: float) -> np.ndarray:
        return orbit(t) @ np.diag([3, 3, 3, 1]).astype(np.float32)

    a, b = (path("walk", 1, 3, Route("o", ROUTE.points, recorded=r)) for r in (orbit, scaled))
    for x, y in zip(a.cameras, b.cameras):
        np.testing.assert_allclose(x.view, y.view, atol=1e-6)


@pytest.mark.parametrize("style", STYLES)
def test_the_clock_runs_at_sixty_frames_a_second(style):
    seconds = path(style, 0, 5).seconds
    np.testing.assert_allclose(np.diff(seconds), 1 / 60)
    assert 0 <= seconds[0] < 60


@pytest.mark.parametrize("count", [6, 7, 8, 12, 25])
def test_the_splits_share_no_route_and_have_all_of_them(count):
    routes = [Route(str(k), ROUTE.points) for k in range(count)]
    scene = Scene("s", (), (), (), routes)
    names = [{r.name for r in split_routes(scene, split)} for split in ("train", "val", "test")]
    assert all(names)
    assert sum(map(len, names)) == len(set.union(*names)) == count
