"""The real thing: skipped where SuperTuxKart's data are not installed."""

import numpy as np
import pytest

from supersampling.scenes.scene import Scene
from supersampling.scenes.stk import available_tracks, find_data, load_track

pytestmark = [pytest.mark.stk, pytest.mark.skipif(find_data() is None, reason="SuperTuxKart's data are not installed")]


@pytest.fixture(scope="module")
def garden() -> Scene:
    return load_track("zengarden")


def world_triangles(scene: Scene) -> np.ndarray:
    """``(N, 3, 3)`` corners of everything that stands still."""
    parts = []
    for item in scene.objects:
        if not item.moves:
            matrix = item.at(0.0).astype(np.float64)
            for k in item.meshes:
                mesh = scene.meshes[k]
                parts.append((mesh.positions @ matrix[:3, :3].T + matrix[:3, 3])[mesh.triangles])
    return np.concatenate(parts)


def ground_below(point: np.ndarray, triangles: np.ndarray) -> float:
    """Height of the highest triangle under a point, by barycentric coordinates in plan."""
    a, b, c = (triangles[:, k] for k in range(3))
    e1, e2, q = (b - a)[:, [0, 2]], (c - a)[:, [0, 2]], point[[0, 2]] - a[:, [0, 2]]
    det = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    flat = np.where(np.abs(det) > 1e-9, det, np.inf)
    u = (q[:, 0] * e2[:, 1] - q[:, 1] * e2[:, 0]) / flat
    v = (e1[:, 0] * q[:, 1] - e1[:, 1] * q[:, 0]) / flat
    height = a[:, 1] + u * (b - a)[:, 1] + v * (c - a)[:, 1]
    under = (np.abs(det) > 1e-9) & (u >= 0) & (v >= 0) & (u + v <= 1) & (height < point[1])
    return float(height[under].max()) if under.any() else -np.inf


def test_the_garden_has_its_size(garden: Scene) -> None:
    drawn = sum(len(garden.meshes[k].triangles) for item in garden.objects for k in item.meshes)
    assert 45_000 < drawn < 200_000
    assert len(garden.materials) > 30
    points = np.concatenate([route.points for route in garden.routes])
    # The corners in quads.xml span x from -179.4 to 6.4 and z from -76.9 to 61.3 in the game's space.
    assert (points.min(axis=0)[[0, 2]] > (-179.4, -61.3)).all()
    assert (points.max(axis=0)[[0, 2]] < (6.4, 76.9)).all()
    assert (np.ptp(points, axis=0)[[0, 2]] > (160.0, 110.0)).all()
    assert "Jean-Manuel" in garden.attribution
    assert "CC-BY-SA" in garden.attribution


def test_routes_run_at_eye_height_over_the_ground(garden: Scene) -> None:
    triangles = world_triangles(garden)
    assert len(garden.routes) >= 8
    for route in garden.routes:
        for point in route.points[::15].astype(np.float64):
            assert 1.0 < point[1] - ground_below(point, triangles) < 4.0


def test_faces_and_normals_agree(garden: Scene) -> None:
    agree = total = 0
    for mesh in garden.meshes:
        a, b, c = (mesh.positions[mesh.triangles[:, k]] for k in range(3))
        facing = (np.cross(b - a, c - a) * mesh.normals[mesh.triangles].mean(axis=1)).sum(axis=1)
        agree, total = agree + int((facing > 0).sum()), total + int((facing != 0).sum())
    assert agree > 0.99 * total


def test_every_array_is_sound(garden: Scene) -> None:
    for mesh in garden.meshes:
        assert mesh.triangles.max() < len(mesh.positions)
        for values in (mesh.positions, mesh.normals, mesh.uv):
            assert values.dtype == np.float32
            assert np.isfinite(values).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)


def test_the_three_tracks_to_start_with_are_there() -> None:
    assert {"zengarden", "ravenbridge_mansion", "black_forest"} <= set(available_tracks())
