"""Checks that every built-in scene must pass."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.scene import Object, Scene

Points = NDArray[np.float64]


def check_meshes(scene: Scene, most_triangles: int = 80_000, most_texels: float = 20e6) -> None:
    """Assert that meshes are sound, used exactly once, face along their normals and use every material."""
    assert sorted(m for o in scene.objects for m in o.meshes) == list(range(len(scene.meshes)))
    assert {m.material for m in scene.meshes} == set(range(len(scene.materials)))
    agreeing = total = 0
    for mesh in scene.meshes:
        count = len(mesh.positions)
        assert mesh.positions.dtype == np.float32
        assert mesh.triangles.dtype == np.uint32
        assert mesh.triangles.max() < count == len(mesh.normals) == len(mesh.uv)
        assert mesh.colors is None or len(mesh.colors) == count
        assert np.isfinite(mesh.positions).all()
        assert np.isfinite(mesh.uv).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-3)
        p, q, r = (mesh.positions[mesh.triangles[:, k]].astype(np.float64) for k in range(3))
        along = (np.cross(q - p, r - p) * mesh.normals[mesh.triangles].mean(axis=1)).sum(axis=1)
        agreeing, total = agreeing + int((along > 0).sum()), total + len(along)
    assert agreeing > 0.99 * total
    assert total <= most_triangles
    maps = {id(t): t for m in scene.materials for t in (m.albedo, m.normal, m.surface) if t is not None}
    assert sum(t.shape[0] * t.shape[1] for t in maps.values()) <= most_texels


def check_motion(scene: Scene) -> None:
    """Assert that moving objects in the world are rigid and never jump between 0 and 60 s."""
    times = np.arange(0.0, 60.0, 1.0 / 15.0)
    for thing in _movers(scene):
        points = np.concatenate([scene.meshes[m].positions for m in thing.meshes]).astype(np.float64)
        corners = np.concatenate([points[points.argmin(axis=0)], points[points.argmax(axis=0)]])
        poses = np.stack([thing.at(float(t)) for t in times]).astype(np.float64)
        turns = poses[:, :3, :3]
        eye = np.broadcast_to(np.eye(3), turns.shape)
        np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), eye, atol=1e-4)
        places = np.einsum("tij,nj->tni", turns, corners) + poses[:, None, :3, 3]
        step = np.linalg.norm(np.diff(places, axis=0), axis=2).max(axis=1)
        assert step.max() > 1e-4
        # A jump is a step far longer than both its neighbours.
        assert (step[1:-1] <= 3.0 * np.maximum(step[:-2], step[2:]) + 0.02).all()


def check_routes(scene: Scene, clearance: float = 0.3) -> None:
    """Assert at least 8 routes of different names, their eyes ``clearance`` metres away from all objects."""
    assert len({r.name for r in scene.routes}) == len(scene.routes) >= 8
    standing = _triangles(scene, [o for o in scene.objects if not o.moves], 0.0)
    moving = [_triangles(scene, _movers(scene), float(t)) for t in np.linspace(0.0, 60.0, 13)]
    for route in scene.routes:
        if route.recorded is not None:
            poses = np.stack([route.recorded(float(t)) for t in np.linspace(0.0, 60.0, 31)])
            turns = poses[:, :3, :3]
            identity = np.broadcast_to(np.eye(3), turns.shape)
            np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), identity, atol=1e-4)
            eyes = np.unique(poses[:, :3, 3].astype(np.float64), axis=0)
        else:
            points = np.asarray(route.points, np.float64)
            assert 5.0 <= np.linalg.norm(np.diff(points, axis=0), axis=1).sum() <= 25.0, route.name
            assert route.focus is None or np.asarray(route.focus).shape[1] == 3
            share = np.linspace(0.0, 1.0, 12)[:, None]
            eyes = np.concatenate([a + share * (b - a) for a, b in pairwise(points)])
        for triangles in (standing, *moving):
            close = (triangles.min(axis=1) < eyes.max(axis=0) + 1.0) & (triangles.max(axis=1) > eyes.min(axis=0) - 1.0)
            around = triangles[close.all(axis=1)]
            assert all(nearest(eye, around) > clearance for eye in eyes), route.name


def check_equal(first: Scene, second: Scene) -> None:
    """Assert that two builds are equal to the bit."""
    for a, b in zip(first.meshes, second.meshes, strict=True):
        for name in ("positions", "normals", "uv", "triangles", "colors"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    for m, n in zip(first.materials, second.materials, strict=True):
        for name in ("albedo", "normal", "surface"):
            np.testing.assert_array_equal(getattr(m, name), getattr(n, name))
    for o, p in zip(first.objects, second.objects, strict=True):
        np.testing.assert_array_equal(o.at(1.5), p.at(1.5))


def nearest(eye: Points, triangles: Points, reach: float = 1.0) -> float:
    """Return the distance from ``eye (3,)`` to the nearest of ``triangles (M, 3, 3)``, at most ``reach``."""
    lo, hi = triangles.min(axis=1), triangles.max(axis=1)
    close = triangles[((lo < eye + reach) & (hi > eye - reach)).all(axis=1)]
    if len(close) == 0:
        return reach
    least = np.full(len(close), reach)
    normal = np.cross(close[:, 1] - close[:, 0], close[:, 2] - close[:, 0])
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    inside = np.ones(len(close), dtype=bool)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        edge, to_eye = close[:, b] - close[:, a], eye - close[:, a]
        share = np.clip((to_eye * edge).sum(axis=1) / np.maximum((edge**2).sum(axis=1), 1e-12), 0.0, 1.0)
        least = np.minimum(least, np.linalg.norm(to_eye - share[:, None] * edge, axis=1))
        inside &= (np.cross(edge, to_eye) * unit).sum(axis=1) >= 0.0
    height = np.abs(((eye - close[:, 0]) * unit).sum(axis=1))
    return float(np.where(inside, np.minimum(least, height), least).min())


def _movers(scene: Scene) -> list[Object]:
    """Return the moving objects in the world; those tied to the camera have no path of their own."""
    return [o for o in scene.objects if o.moves and o.frame == "world"]


def _triangles(scene: Scene, objects: list[Object], seconds: float) -> Points:
    triangles = [np.zeros((0, 3, 3))]
    for thing in objects:
        pose = thing.at(seconds).astype(np.float64)
        for m in thing.meshes:
            corners = scene.meshes[m].positions.astype(np.float64) @ pose[:3, :3].T + pose[:3, 3]
            triangles.append(corners[scene.meshes[m].triangles])
    return np.concatenate(triangles)
