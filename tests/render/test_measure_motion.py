"""Measures of motion against scenes whose numbers are known in closed form."""

import numpy as np
import pytest
from analytic_scenes import camera, eye, hit, pixel_points, project, rays, scene, shift, turn, wall
from measured_scenes import FOCAL, moment, noise

from supersampling.render.camera import Window
from supersampling.render.measure.motion import agreement, disocclusion, edges, near_agreement, reprojection
from supersampling.render.measure.probe import Probe, around
from supersampling.render.measure.scene import agreements
from supersampling.scenes.scene import Material, Scene


def sliding(z: float, speed: float, half: float = 1.0) -> Scene:
    """A square at depth ``-z`` that moves right by ``speed`` metres a second, before a wall at 10 m."""
    materials = [Material("back", noise(1)), Material("front", noise(2))]
    meshes = [wall(-20, 20, -12, 12, -10.0), wall(-half, half, -half, half, z, 1)]
    return scene(materials, meshes, [shift(0, 0, 0), lambda t: shift(speed * t, 0, 0)])


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


def test_disocclusion_is_the_band_behind_a_sliding_square():
    # In 1/60 s it moves by 0.4 m, and leaves a band as wide.
    world = sliding(-4.0, 24.0)
    step = 0.4 * FOCAL / 4.0 / 4.0  # low-resolution pixels
    height = 2.0 * FOCAL / 4.0 / 4.0
    with Probe(world) as probe:
        measured = disocclusion(probe, moment(camera(), seconds=1 / 60))
    for band in (measured.hidden, measured.by_object):
        assert band.sum() == pytest.approx(step * height, rel=0.03)
        columns = np.nonzero(band.any(axis=0))[0]
        left = 240.0 - 1.0 * FOCAL / 16.0
        assert columns.min() == pytest.approx(left, abs=1.0)
        assert columns.max() == pytest.approx(left + step, abs=1.0)
    for name, (right, marked, hit_, true) in agreements(measured).items():
        share = 0.999 if name.endswith("near") else 0.95
        assert right / marked >= share, name
        assert hit_ / true >= share, name


def test_agreement_counts_by_hand():
    mask, truth = np.zeros((5, 7), bool), np.zeros((5, 7), bool)
    mask[1, 1] = mask[1, 2] = mask[4, 6] = True
    truth[1, 2] = truth[2, 3] = truth[4, 0] = True
    judged = np.ones_like(mask)
    assert agreement(mask, truth, judged).tolist() == [1, 3, 1, 3]
    assert near_agreement(mask, truth, truth, truth, judged).tolist() == [2, 3, 2, 3]
    nearly = truth.copy()
    nearly[4, 6] = True
    surely = truth.copy()
    surely[4, 0] = False
    assert near_agreement(mask, truth, nearly, surely, judged).tolist() == [3, 3, 2, 2]
    judged[4] = False
    assert agreement(mask, truth, judged).tolist() == [1, 2, 1, 2]
