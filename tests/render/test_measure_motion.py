"""Measures of motion against scenes whose numbers are known in closed form."""

import numpy as np
from analytic_scenes import camera, eye, hit, pixel_points, project, rays, turn
from measured_scenes import moment, sliding

from supersampling.render.camera import Window
from supersampling.render.measure.motion import edges, reprojection
from supersampling.render.measure.probe import Probe, around


def test_previous_places_are_those_of_the_pinhole_camera():
    window = Window(96, 64, 0, 0, 96, 64)
    world = sliding(-4.0, 2.0)
    now, before = camera((0.2, 0.1, 0.3), turn(0.1, 0.05, 0.02)), camera((0.0, -0.1, 0.0), turn(0.04))
    shot = moment(now, before, 0.5, 0.25, window)
    ray = rays(now, window, pixel_points(window, 1, (0.0, 0.0)))
    depth_back = hit(eye(now), ray, np.array((0, 0, -10.0)), np.array((0, 0, 1.0)))
    depth_front = hit(eye(now), ray, np.array((0, 0, -4.0)), np.array((0, 0, 1.0)))
    place = eye(now) + depth_front[..., None] * ray
    front = (np.abs(place[..., 0] - 1.0) < 1.0) & (np.abs(place[..., 1]) < 1.0)
    world_points = np.where(front[..., None], place - (0.5, 0, 0), eye(now) + depth_back[..., None] * ray)
    with Probe(world) as probe:
        points = probe.previous(shot, (96, 64), 1.0 / np.where(front, depth_front, depth_back), np.where(front, 2, 1))
    np.testing.assert_allclose(points.uv * (96, 64), project(before, window, world_points), atol=1e-6)
    then = -((world_points - eye(before)) @ before.view[:3, :3].T)[..., 2]
    np.testing.assert_allclose(points.inverse, 1.0 / then, rtol=1e-9)


def test_edges_are_jumps_and_creases_not_slopes():
    y, x = np.mgrid[0:9, 0:20].astype(float)
    slope = 0.1 + 0.002 * x + 0.001 * y
    same = np.ones(x.shape, int)
    assert not edges(same, slope)[1:-1, 1:-1].any()
    crease = np.where(x < 10, slope, slope[:, :1] + 0.02 - 0.002 * (x - 10))
    assert set(np.nonzero(edges(same, crease)[4, 1:-1])[0] + 1) == {10}
    assert set(np.nonzero(edges(np.where(x < 10, 1, 2), slope)[4, 1:-1])[0] + 1) == {9, 10}


def test_reprojection_of_right_motion_is_small_and_of_wrong_motion_is_not(monkeypatch):
    world = sliding(-4.0, 1.2)
    before = camera((0.0, 0.0, 0.0))
    shot = moment(camera((0.02, 0.01, 0.0), turn(0.005)), before, 1 / 60, 0.0, around(0.6, 0.5, 640, 4))
    with Probe(world) as probe:
        right = reprojection(probe, shot)
        rendered = probe.renderer.low

        def off(*arguments):
            """Motion that is two target pixels off."""
            out = rendered(*arguments)
            return {n: image + 8.0 / 640.0 if n == "motion" else image for n, image in out.items()}

        monkeypatch.setattr(probe.renderer, "low", off)
        wrong = reprojection(probe, shot)
    for (error, count), (worse, as_many) in zip((right.still, right.moving), (wrong.still, wrong.moving)):
        assert min(count, as_many) > 20_000
        assert error / count < 0.3 / 255.0
        assert worse / count > 1.0 / 255.0
