"""Node animations, lights and cameras against closed forms."""

from pathlib import Path

import numpy as np
import pytest
from gltf_files import Builder
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation, Slerp

from supersampling.render.paths import split_routes
from supersampling.scenes.gltf import load_gltf
from supersampling.scenes.scene import Scene


def loaded(file: Builder, path: Path) -> Scene:
    return load_gltf(file.glb(path / "a.glb"))


def test_rotations_are_slerped_along_the_shorter_arc_and_loop(tmp_path: Path) -> None:
    turns = Rotation.from_euler("xyz", [[0, 0, 0], [20, 100, -30], [170, 10, 80]], degrees=True)
    keys = turns.as_quat()
    keys[1] *= -1.0  # the same rotation
    file = Builder()
    node = file.node(mesh=file.square(), translation=[0, 0, 1])
    file.animate(node, "rotation", [0.5, 1.5, 2.0], keys)
    (item,) = loaded(file, tmp_path).objects
    assert item.moves
    truth = Slerp([0.5, 1.5, 2.0], turns)
    for seconds in (0.5, 0.7, 1.5, 1.9):
        for loop in (0.0, 2.0, 14.0):
            np.testing.assert_allclose(item.at(seconds + loop)[:3, :3], truth([seconds]).as_matrix()[0], atol=2e-6)
    np.testing.assert_allclose(item.at(0.2)[:3, :3], np.eye(3), atol=1e-6)  # held before the first key
    np.testing.assert_allclose(item.at(0.7)[:3, 3], [0, 0, 1])


def test_translations_step_scales_and_children_move_along(tmp_path: Path) -> None:
    file = Builder()
    leaf = file.node(mesh=file.square(), translation=[1, 0, 0])
    root = file.node(children=[leaf])
    file.node(mesh=file.square(), translation=[0, 5, 0])
    file.animate(root, "translation", [0, 2], [[0, 0, 0], [4, 0, 0]])
    file.animate(root, "scale", [0, 1, 2], [[1, 1, 1], [3, 1, 1], [0, 0, 0]], "STEP")
    still, moving = sorted(loaded(file, tmp_path).objects, key=lambda item: item.moves)
    assert not still.moves
    # x = 2t + scale * 1
    np.testing.assert_allclose([moving.at(t)[0, 3] for t in (0.0, 0.75, 1.0, 1.75)], [1.0, 2.5, 5.0, 6.5], atol=1e-6)
    np.testing.assert_allclose(moving.at(1.5)[:3, 0], [3, 0, 0], atol=1e-6)


def test_cubic_splines_are_hermite(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    times = np.array([0.0, 0.5, 2.0])
    values, tangents = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    quaternions, spins = Rotation.random(3, rng=1).as_quat(), rng.normal(size=(3, 4))
    file = Builder()
    node = file.node(mesh=file.square())
    for path, value, slope in (("translation", values, tangents), ("rotation", quaternions, spins)):
        # Each key: in-tangent, value, out-tangent.
        file.animate(node, path, times, np.stack([slope, value, slope], axis=1).reshape(9, -1), "CUBICSPLINE")
    (item,) = loaded(file, tmp_path).objects
    where, turned = CubicHermiteSpline(times, values, tangents), CubicHermiteSpline(times, quaternions, spins)
    for seconds in (0.0, 0.2, 0.5, 1.3, 1.99):
        np.testing.assert_allclose(item.at(seconds)[:3, 3], where(seconds), atol=1e-5)
        np.testing.assert_allclose(item.at(seconds)[:3, :3], Rotation.from_quat(turned(seconds)).as_matrix(), atol=1e-5)


def test_what_is_animated_by_the_same_value_stands_still(tmp_path: Path) -> None:
    file = Builder()
    node = file.node(mesh=file.square())
    file.animate(node, "translation", [0, 1, 2], [[7, 0, 0]] * 3)
    (item,) = loaded(file, tmp_path).objects
    assert not item.moves
    assert item.at(0.0)[0, 3] == 7.0


def test_cameras_become_recorded_routes(tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.square())
    lens = file.add("cameras", {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}})
    flat = file.add(
        "cameras", {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 9}}
    )
    half = np.sqrt(0.5)
    # A quarter turn about y under a parent of twice the size: the camera looks down -x.
    eye = file.node(camera=lens, name="fixed", translation=[1, 2, 3], rotation=[0, half, 0, half])
    file.node(children=[eye], scale=[2, 2, 2])
    ride = file.node(camera=lens, name="ride")
    file.node(camera=flat)
    file.animate(ride, "translation", [0, 4], [[0, 0, 5], [4, 0, 5]])
    with pytest.warns(UserWarning, match="not perspective"):
        scene = loaded(file, tmp_path)
    fixed, moving = (next(r for r in scene.routes if r.name == name) for name in ("fixed", "ride"))
    expected = np.array([[0, 0, 1, 2], [0, 1, 0, 4], [-1, 0, 0, 6], [0, 0, 0, 1]])
    assert fixed.recorded is not None
    np.testing.assert_allclose(fixed.recorded(3.0), expected, atol=1e-6)
    assert fixed.fov == 0.7
    assert moving.recorded is not None
    np.testing.assert_allclose(
        [moving.recorded(t)[:3, 3] for t in (0.0, 1.0, 3.5)], [[0, 0, 5], [1, 0, 5], [3.5, 0, 5]], atol=1e-6
    )


@pytest.mark.parametrize("size", [1.0, 30.0])
def test_every_split_has_several_routes_that_see_the_scene(size: float, tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.square(), scale=[size] * 3)
    file.node(mesh=file.square(), scale=[size] * 3, rotation=[0, np.sqrt(0.5), 0, np.sqrt(0.5)])
    scene = loaded(file, tmp_path)
    centres = []
    for split in ("train", "val", "test"):
        routes = split_routes(scene, split)
        assert len(routes) >= 3
        for route in routes:
            assert np.linalg.norm(np.diff(route.points, axis=0), axis=1).sum() > 0.5
            # The far plane lies behind the farthest corner as seen from anywhere on the route.
            corner = size * np.array((1.0, 1.0, 1.0)) * -np.sign(route.points)
            assert np.linalg.norm(route.points - corner, axis=1).max() < scene.far
            centres.append(route.points.mean(axis=0))
    apart = np.linalg.norm(np.array(centres)[:, None] - np.array(centres), axis=-1) + 1e9 * np.eye(len(centres))
    assert apart.min() > 0.01 * size


def lights(file: Builder, tmp_path: Path, *where: dict) -> Scene:
    file.node(mesh=file.square())
    for number, item in enumerate(where):
        file.node(**item, extensions={"KHR_lights_punctual": {"light": number}})
    return loaded(file, tmp_path)


def test_units_of_lights_keep_their_ratios(tmp_path: Path) -> None:
    """A lamp of 80 cd gives 20 lx at 2 m; a sun of 10 lx gives half as much everywhere."""
    file = Builder()
    file.light(type="directional", intensity=10.0, color=[1.0, 0.5, 0.25])
    file.light(type="point", intensity=80.0, range=6.0)
    half = np.sqrt(0.5)
    scene = lights(file, tmp_path, {"rotation": [-half, 0, 0, half]}, {"translation": [0, 0, 2]})
    assert scene.sun is not None
    np.testing.assert_allclose(scene.sun.direction, [0, 1, 0], atol=1e-6)  # -z turned to -y: the light comes from above
    (lamp,) = scene.points
    assert lamp.radius == 6.0
    assert lamp.cone is None
    # Radiance / pi of a surface that faces each: intensity / d^2 and the sun's radiance.
    np.testing.assert_allclose(np.array(lamp.intensity) / 2.0**2 / scene.sun.radiance, [2.0, 4.0, 8.0], rtol=1e-6)


def test_a_model_that_is_brought_to_size_is_lit_as_before(tmp_path: Path) -> None:
    """0.002 cd at 1 cm are 20 lx, twice the sun's 10 lx, also when the centimetre has become half a metre."""
    file = Builder()
    file.light(type="directional", intensity=10.0)
    file.light(type="point", intensity=0.002, range=0.06)
    file.node(mesh=file.square(), scale=[0.01] * 3)
    file.node(extensions={"KHR_lights_punctual": {"light": 0}})
    file.node(translation=[0, 0, 0.01], extensions={"KHR_lights_punctual": {"light": 1}})
    scene = loaded(file, tmp_path)
    (lamp,) = scene.points
    distance = lamp.position[2]
    assert distance == pytest.approx(lamp.radius / 6.0)
    assert distance > 0.1
    assert scene.sun is not None
    np.testing.assert_allclose(np.array(lamp.intensity) / distance**2 / scene.sun.radiance, 2.0, rtol=1e-5)


def test_the_brightest_light_sets_the_level_whatever_its_unit(tmp_path: Path) -> None:
    suns = []
    for lux in (0.5, 100000.0):
        file = Builder()
        file.light(type="directional", intensity=lux)
        file.light(type="directional", intensity=lux / 10)
        with pytest.warns(UserWarning, match="of several directional lights only the brightest"):
            scene = lights(file, tmp_path, {}, {"translation": [0, 0, 1]})
        assert scene.sun is not None
        suns.append(scene.sun.radiance)
    np.testing.assert_allclose(suns[0], [3.0, 3.0, 3.0], rtol=1e-6)
    np.testing.assert_allclose(suns[0], suns[1], rtol=1e-6)


def test_spots_shine_along_their_node(tmp_path: Path) -> None:
    file = Builder()
    file.light(type="spot", spot={"innerConeAngle": 0.2, "outerConeAngle": 0.6}, intensity=5.0)
    scene = lights(file, tmp_path, {"translation": [0, 0, 3]})
    (spot,) = scene.points
    assert spot.cone == (0.2, 0.6)
    np.testing.assert_allclose(spot.direction, [0, 0, -1], atol=1e-6)
    np.testing.assert_allclose(spot.position, [0, 0, 3])
    assert scene.sun is None


def test_a_file_without_lights_gets_a_sun_and_a_sky(tmp_path: Path) -> None:
    scene = lights(Builder(), tmp_path)
    assert scene.sun is not None
    assert not scene.points
