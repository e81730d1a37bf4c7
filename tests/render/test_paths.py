from itertools import pairwise

import numpy as np
import pytest

from supersampling.render.paths import camera_path, look_at, routes_of
from supersampling.render.scene import Route, Scene

ROUTE = Route("line", np.array([(0, 1.6, 0), (0, 1.6, -6), (3, 1.6, -9)], dtype=np.float32))


def test_look_at_puts_the_target_on_the_axis():
    eye, forward = np.array((1.0, 2.0, 3.0)), np.array((0.3, -0.1, -0.8))
    view = look_at(eye, forward)
    ahead = view @ np.append(eye + 2.5 * forward, 1.0)
    np.testing.assert_allclose(ahead[:2], 0.0, atol=1e-12)
    assert ahead[2] < 0
    np.testing.assert_allclose(view[:3, :3] @ view[:3, :3].T, np.eye(3), atol=1e-12)
    assert (view[:3, :3] @ (0, 1, 0))[1] > 0
    assert np.linalg.det(view[:3, :3]) == pytest.approx(1.0)


def test_equal_seeds_give_equal_paths_and_others_differ():
    a, b, c = (camera_path(ROUTE, np.random.default_rng(seed), 12) for seed in (4, 4, 5))
    assert all((x.view == y.view).all() for x, y in zip(a.cameras, b.cameras))
    assert not (a.cameras[3].view == c.cameras[3].view).all()


def test_some_cameras_stand_exactly_still_for_a_while_and_all_move():
    still = 0
    for seed in range(40):
        views = [c.view for c in camera_path(ROUTE, np.random.default_rng(seed), 24).cameras]
        same = [bool((a == b).all()) for a, b in pairwise(views)]
        assert not all(same)
        still += sum(same) >= 6
    assert 10 <= still <= 30


def test_the_clock_runs_at_sixty_frames_a_second():
    seconds = camera_path(ROUTE, np.random.default_rng(0), 5).seconds
    np.testing.assert_allclose(np.diff(seconds), 1 / 60)


def test_eyes_stay_on_the_route():
    for seed in range(20):
        for camera in camera_path(ROUTE, np.random.default_rng(seed), 24).cameras:
            eye = -camera.view[:3, :3].T @ camera.view[:3, 3]
            assert eye[1] == pytest.approx(1.6)
            gap = [
                np.linalg.norm(eye - p)
                for s in (0, 1)
                for p in np.linspace(ROUTE.points[s], ROUTE.points[s + 1], 60)
            ]
            assert min(gap) < 0.4  # corners are rounded


def test_splits_share_no_route():
    routes = [Route(str(k), ROUTE.points) for k in range(8)]
    scene = Scene("s", (), (), (), routes)
    names = [{r.name for r in routes_of(scene, split)} for split in ("train", "val", "test")]
    assert all(names)
    assert sum(map(len, names)) == len(set.union(*names)) == 8
