"""Measures of what a scene shows against scenes whose numbers are known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_scenes import DARK, camera, glow, quad, scene, shift, turn, wall
from measured_scenes import FOCAL, MATTE, moment, noise

from supersampling.frames import BUFFERS
from supersampling.render.camera import Window
from supersampling.render.measure import costs
from supersampling.render.measure.look import (
    detail,
    gradient_energy,
    interface_share,
    lighting_energy,
    shadow_change,
    speeds,
)
from supersampling.render.measure.probe import Probe, by_mesh, seeded_shots, standing
from supersampling.render.measure.scene import details
from supersampling.scenes.scene import Material, PointLight, Route, Scene, Sun


def test_gradient_energy_is_scale_free_and_right_by_hand():
    values = np.array([[1.0, 3.0], [2.0, 2.0]])[..., None]
    chosen = np.ones((2, 2), bool)
    a, b, c = np.log1p(np.array([1.0, 3.0, 2.0]) / 2.0)
    expected = ((a - b) ** 2 + (a - c) ** 2 + (b - c) ** 2 + 0.0) / 4.0
    assert gradient_energy(values, chosen) == pytest.approx(expected)
    assert gradient_energy(1000.0 * values, chosen) == pytest.approx(expected)
    chosen[0, 1] = False  # the three others have the mean 5/3
    e, f = np.log1p(np.array([1.0, 2.0]) / (5.0 / 3.0))
    assert gradient_energy(values, chosen) == pytest.approx(((e - f) ** 2 + 0.0) / 2.0)
    assert gradient_energy(values, ~np.ones((2, 2), bool)) == 0.0
    assert gradient_energy(0.0 * values, chosen) == 0.0


def test_lighting_of_a_textured_wall_is_smooth_and_that_of_a_plain_one_is_its_radiance():
    lamp = PointLight((0.0, 0.0, -9.0), (5.0, 5.0, 5.0), 30.0, shadowed=False)
    window = Window(1920, 1080, 832, 476, 256, 128)
    ratios = []
    for albedo in (noise(3), None):
        material = Material("wall", albedo, base_color=(0.6, 0.6, 0.6), roughness=1.0)
        world = scene([material], [wall(-3, 3, -3, 3, -10.0)], points=[lamp])
        with Probe(world) as probe:
            lighting, radiance = lighting_energy(probe, moment(camera(), window=window))
        ratios.append(lighting / radiance)
    assert 0.0 < ratios[0] < 0.2
    assert ratios[1] == pytest.approx(1.0, abs=0.1)


def test_shares_of_a_frame_cut_in_halves():
    half = 1.0001 * np.tan(0.5) * 10 * 16 / 9
    materials = [replace(MATTE, roughness=0.2), replace(MATTE, emission=(1.0, 1.0, 1.0), alpha="test")]
    meshes = [wall(-half, 0, -9, 9, -10.0, 0), wall(0, half, -9, 0, -10.0, 1)]
    world = scene(materials, meshes, [shift(0, 0, 0), lambda t: shift(0.0, 1e-9 * t, 0.0)])
    with Probe(world) as probe:
        seen = speeds(probe, moment(camera((0.1, 0, 0)), camera()))
        found = {name: mask.mean() for name, mask in seen.items() if name != "speed"}
    shift_low = 0.1 * FOCAL / 10 / 1920  # of the width: the camera stepped right, the picture left
    left, right = 0.5 - shift_low, 0.25
    expected = {"solid": left + right, "moving": right, "glossy": left, "emissive": right, "tested": right}
    for name, share in expected.items():
        assert found[name] == pytest.approx(share, abs=0.006), name
    walls = seen["speed"][seen["solid"]]
    np.testing.assert_allclose(walls, 0.1 * FOCAL / 10, rtol=1e-4)


def bars(width: int, period: int, low: int, high: int) -> np.ndarray:
    row = np.where(np.arange(width) % period < period // 2, low, high).astype(np.uint8)
    return np.broadcast_to(row[None, :, None], (8, width, 3)).copy()


def fitted(material: Material) -> Scene:
    """A wall that fills the 1080p frame exactly, its texture once over it."""
    x, y = np.tan(0.5) * 10 * 16 / 9, np.tan(0.5) * 10
    return scene([material], [wall(-x, x, -y, y, -10.0)])


def test_bars_finer_than_a_low_pixel_are_fine_texture_and_coarse_ones_are_not():
    found = {}
    for period in (4, 64):
        with Probe(fitted(Material("bars", bars(1920, period, 60, 200)))) as probe:
            found[period] = details(probe, [moment(camera())])["fine_texture_pixels"]
    assert found[4] > 0.99
    assert found[64] < 0.01  # every bar ends at a low-resolution pixel's side


def test_a_grid_that_nearly_agrees_with_the_pixels_beats():
    # A period of 4.1 target pixels against a pixel of 4 beats every 160 pixels; one of 32 is sampled as it is.
    x = np.arange(1920) + 0.5
    found = {}
    for period in (4.1, 32.0):
        wave = 128 + 80 * np.sin(2 * np.pi * x / period)
        texture = np.round(np.broadcast_to(wave[None, :, None], (8, 1920, 3))).astype(np.uint8)
        with Probe(fitted(Material("wave", texture))) as probe:
            found[period] = details(probe, [moment(camera())])["moire_pixels"]
    assert found[4.1] > 0.5
    assert found[32.0] == 0.0


def test_thin_parts_are_counted_and_broad_ones_are_not():
    pixel = 5.0 / FOCAL  # metres of a target pixel at 5 m
    for width, least, most in ((3.0, 2.5, 3.5), (40.0, 0.0, 0.0)):
        post = wall(-width / 2 * pixel, width / 2 * pixel, -9, 9, -5.0)
        with Probe(scene([MATTE], [wall(-20, 20, -12, 12, -10.0), post])) as probe:
            columns = detail(probe, moment(camera()))["thin"].mean() * 1920
        assert least <= columns <= most


def test_a_shadow_that_moves_is_seen_and_one_that_stands_is_not():
    down = turn(0.0, -np.pi / 2)
    ground = quad(((-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)))
    roof = quad(((-1, 2, 1), (1, 2, 1), (1, 2, -1), (-1, 2, -1)))
    shares_ = []
    for speed in (0.0, 2.0):
        places = [shift(0, 0, 0), lambda t, speed=speed: shift(speed * t, 0, 0)]
        material = replace(MATTE, double_sided=True)
        lamp = Sun((0.0, 1.0, 0.2), (3.0, 3.0, 3.0))
        with Probe(scene([material], [ground, roof], places, sun=lamp, sky=replace(DARK, ambient=0.0))) as probe:
            changed, standing = shadow_change(probe, moment(camera((0, 1.0, 0), down), seconds=1.0))
            shares_.append(changed / standing)
    # The camera is below the roof and sees x within 0.97 m; the shadow's left edge went from 0.5 m to 1 m.
    reach = np.tan(0.5) * 16 / 9
    assert shares_[0] == 0.0
    assert shares_[1] == pytest.approx((reach - 0.5) / (2 * reach), abs=0.01)


def test_interface_covers_what_its_elements_cover():
    reach = np.tan(0.5)
    element = replace(glow(1.0), interface=True)
    panel = wall(0.0, reach * 16 / 9 * 1.01, 0.0, reach * 1.01, -1.0, 1)
    world = scene([MATTE, element], [wall(-20, 20, -12, 12, -10.0), panel])
    assert interface_share(world, [moment(camera())]) == pytest.approx(0.25, abs=0.005)
    assert interface_share(scene([MATTE], [wall(-20, 20, -12, 12, -10.0)]), [moment(camera())]) == 0.0
    plain, owner = by_mesh(world)
    assert len(plain.objects) == 1
    assert owner.tolist() == [0, 1]


def test_standing_cameras_are_counted():
    line = np.array(((0, 0, 0), (0, 0, -9)), np.float32)
    walking = scene([MATTE], [wall(-1, 1, -1, 1, -10.0)])
    stands = Route("stands", line, recorded=lambda seconds: np.eye(4, dtype=np.float32))
    moves = Route("moves", line, recorded=lambda seconds: shift(seconds, 0, 0))
    halting = Route("halts", line, recorded=lambda seconds: shift(min(seconds % 0.5, 0.25), 0, 0))
    assert standing(replace(walking, routes=[stands])) == (1.0, 1.0)
    assert standing(replace(walking, routes=[moves])) == (0.0, 0.0)
    assert standing(replace(walking, routes=[moves, stands])) == (0.5, 0.5)
    assert standing(replace(walking, routes=[halting])) == (0.0, pytest.approx(0.5, abs=0.05))


def test_shots_are_repeatable_and_take_test_and_training_routes_in_turn():
    line = np.array(((0, 0, 0), (0, 0, -9)), np.float32)
    routes = [Route(str(k), line + np.float32((100 * k, 0, 0))) for k in range(6)]
    world = replace(scene([MATTE], [wall(-1, 1, -1, 1, -10.0)]), routes=routes)
    first, second = seeded_shots(world, 6), seeded_shots(world, 6)
    assert [s.seconds for s in first] == [s.seconds for s in second]
    taken = [round(float(np.linalg.inv(s.camera.view)[0, 3]) / 100) for s in first]
    assert [k in (1, 5) for k in taken] == [True, False] * 3  # routes 1 and 5 are for testing
    assert 3 not in taken  # for validation
    assert len(set(taken)) == 5


def test_costs_name_every_buffer_and_its_size(monkeypatch):
    monkeypatch.setattr(costs, "SIDE", 32)
    monkeypatch.setattr(costs, "FRAMES", 2)
    line = np.array(((0, 0, 0), (0, 0, -3)), np.float32)
    world = replace(scene([MATTE], [wall(-9, 9, -9, 9, -10.0)]), routes=[Route(str(k), line) for k in range(6)])
    found = {cost.name: cost for cost in costs.costs(world)}
    assert set(found) == set(BUFFERS) - {"jitter"}
    assert found["target"].raw == 32 * 32 * 3
    assert found["depth"].raw == 8 * 8 * 4
    assert found["high_motion"].raw == 32 * 32 * 2 * 4
    for cost in found.values():
        assert 0 < cost.stored < cost.raw + 200  # a black square compresses well, but gzip has a header
        assert cost.seconds > 0
    table = costs.table(list(found.values()))
    assert table.count("\n") == len(found) + 1
    assert "| `high_albedo` | 3 x float16 |" in table
