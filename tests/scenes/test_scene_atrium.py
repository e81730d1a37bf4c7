"""The atrium is well formed, deterministic, moves smoothly, and its routes are clear of all objects."""

import numpy as np
import pytest
from built_scenes import built
from scipy.spatial import cKDTree

from supersampling.scenes.atrium.atrium import HEIGHT, LENGTH, WIDTH
from supersampling.scenes.scene import Mesh, Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("atrium")


def _geometric_normals(mesh: Mesh) -> np.ndarray:
    a, b, c = (mesh.positions[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
    return np.cross(b - a, c - a)


def _world_points(scene: Scene, moving: bool, seconds: float = 0.0) -> list[np.ndarray]:
    points_of_objects = []
    for thing in scene.objects:
        if thing.moves == moving:
            points = np.concatenate([scene.meshes[m].positions for m in thing.meshes])
            matrix = thing.at(seconds)
            points_of_objects.append(points @ matrix[:3, :3].T + matrix[:3, 3])
    return points_of_objects


def test_meshes_are_well_formed(scene: Scene) -> None:
    for mesh in scene.meshes:
        assert mesh.triangles.dtype == np.uint32
        assert mesh.positions.dtype == np.float32
        assert mesh.triangles.max() < len(mesh.positions) == len(mesh.normals) == len(mesh.uv)
        assert np.isfinite(mesh.positions).all()
        assert np.isfinite(mesh.uv).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
        assert 0 <= mesh.material < len(scene.materials)
        assert mesh.colors is None or len(mesh.colors) == len(mesh.positions)


def test_front_faces_agree_with_vertex_normals(scene: Scene) -> None:
    agree = [
        (_geometric_normals(mesh) * mesh.normals[mesh.triangles].mean(axis=1)).sum(axis=1) > 0 for mesh in scene.meshes
    ]
    assert np.concatenate(agree).mean() > 0.99


def test_every_mesh_is_drawn_once_and_within_the_triangle_budget(scene: Scene) -> None:
    used = sorted(m for thing in scene.objects for m in thing.meshes)
    assert used == list(range(len(scene.meshes)))
    assert 40_000 < sum(len(mesh.triangles) for mesh in scene.meshes) < 120_000


def test_everything_stands_within_the_courtyard(scene: Scene) -> None:
    half = np.array([LENGTH / 2, HEIGHT, WIDTH / 2]) + 0.2
    for seconds in (0.0, 3.3, 7.7):
        for points in _world_points(scene, False) + _world_points(scene, True, seconds):
            assert (np.abs(points) < half).all()
            assert points[:, 1].min() > -0.01


def test_movers_move_smoothly_and_rigidly(scene: Scene) -> None:
    movers = [thing for thing in scene.objects if thing.moves]
    assert len(movers) >= 5
    step, times = 1 / 60, np.linspace(0.0, 20.0, 41)
    for thing in movers:
        points = np.concatenate([scene.meshes[m].positions for m in thing.meshes])[::7]
        places = []
        for t in times:
            now = [thing.at(t + k * step) for k in range(3)]
            np.testing.assert_allclose(now[0][:3, :3] @ now[0][:3, :3].T, np.eye(3), atol=1e-5)
            a, b, c = (points @ m[:3, :3].T + m[:3, 3] for m in now)
            # At most 4 m/s, and a change of speed of at most 40 m/s^2.
            assert np.abs(b - a).max() < 4 * step
            assert np.abs(a - 2 * b + c).max() < 40 * step**2 + 1e-5
            places.append(a)
        assert np.ptp(places, axis=0).max() > 0.05  # it does move


def test_wheels_of_the_cart_roll(scene: Scene) -> None:
    """The point where a wheel touches its rail stands still, while its middle travels."""
    step, rolling = 1e-3, 0
    for thing in scene.objects:
        before, after = thing.at(6.0), thing.at(6.0 + step)
        speed = np.abs(after - before)[:3, 3].max() / step
        if not thing.moves or speed < 0.5:
            continue
        local = np.concatenate([scene.meshes[m].positions for m in thing.meshes])
        world = local @ before[:3, :3].T + before[:3, 3]
        moved = (local @ after[:3, :3].T + after[:3, 3])[world[:, 1] < world[:, 1].min() + 0.002]
        contact = np.abs(moved - world[world[:, 1] < world[:, 1].min() + 0.002])[:, 0].max() / step
        if np.ptp(local[:, 0]) < 0.6:  # the wheels; the cart's body is longer
            rolling += 1
            assert contact < 0.1 * speed
    assert rolling == 2


def test_some_movers_cross_several_pixels_a_frame(scene: Scene) -> None:
    # 932 pixels a radian at 1080 lines and 1.05 rad, seen from 5 m.
    fast = 0
    for before, after in zip(_world_points(scene, True, 5.0), _world_points(scene, True, 5.0 + 1 / 60)):
        fast += np.linalg.norm(after - before, axis=1).max() * 932 / 5 > 1.5
    assert fast >= 5


def _surface_points(scene: Scene) -> np.ndarray:
    """Return the vertices of the static objects, and points inside their large triangles."""
    points = []
    weights = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.5, 0), (0, 0.5, 0.5), (0.5, 0, 0.5), (1 / 3, 1 / 3, 1 / 3)]
    for m in scene.objects[0].meshes:
        corners = scene.meshes[m].positions[scene.meshes[m].triangles]
        points += [np.tensordot(corners, w, axes=([1], [0])) for w in weights]
    return np.concatenate(points)


def test_routes_are_eye_high_long_and_clear(scene: Scene) -> None:
    assert len(scene.routes) == 8
    assert len({r.name for r in scene.routes}) == 8
    tree = cKDTree(_surface_points(scene))
    for route in scene.routes:
        assert route.focus is not None
        assert route.focus.shape == route.points.shape
        assert 6.0 <= np.linalg.norm(np.diff(route.points, axis=0), axis=1).sum() <= 15.0
        assert route.points[:, 1].min() >= 1.5
        assert route.points[:, 1].max() <= 1.8
        share = np.linspace(0, len(route.points) - 1, 200)
        line = np.stack([np.interp(share, np.arange(len(route.points)), route.points[:, k]) for k in range(3)], 1)
        distance, _ = tree.query(line)
        assert distance.min() > 0.4, route.name
        for seconds in np.linspace(0, 20, 9):
            moving = cKDTree(np.concatenate(_world_points(scene, True, seconds)))
            assert moving.query(line)[0].min() > 0.3, route.name


def test_materials_with_holes_and_glow_and_lights(scene: Scene) -> None:
    cut = [m for m in scene.materials if m.alpha == "test"]
    assert len(cut) >= 3
    for material in cut:
        assert material.albedo is not None
        assert material.double_sided
        assert 0.05 < (material.albedo[..., 3] < 128).mean() < 0.95
    assert any(max(m.emission) > 1 for m in scene.materials)
    assert scene.sun is not None
    assert 2 <= sum(light.shadowed for light in scene.points) <= 3
    assert "MIT" in scene.attribution
    assert "CC0" in scene.attribution
