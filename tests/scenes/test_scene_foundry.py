"""The foundry is well formed, moves smoothly and leaves its routes free."""

from itertools import pairwise

import numpy as np
import pytest
from built_scenes import built
from scipy.spatial import KDTree

from supersampling.scenes.foundry.parts import meshing_phase, oval
from supersampling.scenes.kit.wheels import gear
from supersampling.scenes.scene import Scene

FRAME = 1.0 / 60.0


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("foundry")


def test_meshes_are_well_formed(scene):
    used = np.concatenate([np.array(o.meshes) for o in scene.objects])
    assert sorted(used) == list(range(len(scene.meshes)))
    for mesh in scene.meshes:
        count = len(mesh.positions)
        assert mesh.normals.shape == (count, 3)
        assert mesh.uv.shape == (count, 2)
        assert mesh.triangles.max() < count
        assert 0 <= mesh.material < len(scene.materials)
        assert np.isfinite(mesh.positions).all()
        assert np.isfinite(mesh.uv).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-3)


def test_front_faces_look_along_their_normals(scene):
    good = total = 0
    for mesh in scene.meshes:
        p, q, r = (mesh.positions[mesh.triangles[:, i]].astype(float) for i in range(3))
        face = np.cross(q - p, r - p)
        good += int((np.einsum("ni,ni->n", face, mesh.normals[mesh.triangles].mean(1)) > 0).sum())
        total += len(face)
    assert good > 0.99 * total


def test_size_of_the_scene(scene):
    triangles = sum(len(m.triangles) for m in scene.meshes)
    assert 40_000 <= triangles <= 120_000
    assert 2 <= sum(p.shadowed for p in scene.points) <= 4
    texels = sum(t.size for m in scene.materials for t in (m.albedo, m.normal, m.surface) if t is not None)
    assert texels < 100e6


def test_materials_of_every_kind(scene):
    assert any(m.alpha == "test" and m.albedo is not None and m.albedo.shape[2] == 4 for m in scene.materials)
    assert any(max(m.emission) > 0 and m.surface is not None for m in scene.materials)
    assert any(m.metallic > 0.9 and m.surface is not None and m.surface[..., 1].mean() > 128 for m in scene.materials)
    drawn = {m.material for m in scene.meshes}
    assert drawn == set(range(len(scene.materials)))


def test_objects_move_smoothly(scene):
    moving = [o for o in scene.objects if o.moves]
    assert len(moving) >= 5
    times = np.linspace(0.0, 70.0, 240)
    for thing in moving:
        points = np.concatenate([scene.meshes[i].positions for i in thing.meshes]).astype(float)
        points = np.concatenate([points[points.argmax(0)], points[points.argmin(0)]])
        points = np.concatenate([points, np.ones((6, 1))], 1).T
        path = np.array([[thing.at(float(t + k * FRAME)) @ points for k in range(3)] for t in times])[:, :, :3]
        step = np.diff(path, axis=1)
        bend = np.diff(step, axis=1)
        assert 1e-4 < np.linalg.norm(step, axis=2).max() < 0.25
        assert np.linalg.norm(bend, axis=2).max() < 0.05
        np.testing.assert_allclose([np.linalg.det(thing.at(float(t))[:3, :3]) for t in times], 1.0, atol=1e-4)


def test_routes_are_clear(scene):
    static = [scene.meshes[i].positions for o in scene.objects if not o.moves for i in o.meshes]
    vertices = np.concatenate(static).astype(float)
    moving = [(o, np.concatenate([scene.meshes[i].positions for i in o.meshes])) for o in scene.objects if o.moves]
    moved = [
        points @ thing.at(t)[:3, :3].T + thing.at(t)[:3, 3]
        for thing, points in moving
        for t in np.linspace(0.0, 30.0, 31)
    ]
    vertices = np.concatenate([vertices, *moved])
    vertices = vertices[(vertices[:, 1] > 0.8) & (vertices[:, 1] < 2.6)]
    tree = KDTree(vertices)
    assert len(scene.routes) == 8
    for route in scene.routes:
        points = np.asarray(route.points, float)
        assert route.focus is not None
        assert route.focus.shape == points.shape
        assert ((points[:, 1] >= 1.5) & (points[:, 1] <= 1.8)).all()
        assert 6.0 <= np.linalg.norm(np.diff(points, axis=0), axis=1).sum() <= 15.0
        share = np.linspace(0, 1, 40)[:, None]
        eyes = np.concatenate([a + share * (b - a) for a, b in pairwise(points)])
        assert tree.query(eyes)[0].min() > 0.4, route.name


@pytest.mark.parametrize(("teeth", "count", "direction"), [(24, 14, 0.4), (17, 32, -1.1), (20, 20, 3.0)])
def test_wheels_mesh_tooth_against_gap(teeth, count, direction):
    phase = 0.37
    for turn in (0.0, 0.05, 0.11):
        # As the first wheel turns, the other turns back by the ratio of their teeth.
        first, second = phase + turn, meshing_phase(teeth, phase, count, direction) - turn * teeth / count
        a = (direction - first) * teeth / (2 * np.pi)
        b = (direction + np.pi - second) * count / (2 * np.pi)
        # A tooth's middle (whole number) of one meets a gap's middle (half) of the other.
        assert (a + b) % 1 == pytest.approx(0.5)


def test_gear_has_its_teeth():
    wheel = gear(18, 0.05, 0.1)
    radius = np.hypot(wheel.positions[:, 0], wheel.positions[:, 1])
    assert radius.max() == pytest.approx(0.45 + 0.045)
    tips = wheel.positions[radius > radius.max() - 1e-6]
    angle = np.unique(np.round(np.arctan2(tips[:, 1], tips[:, 0]) % (2 * np.pi), 6))
    assert len(angle) == 36  # two corners per tooth


def test_oval_is_walked_at_even_speed():
    half, radius = 3.0, 1.1
    around = 4 * half + 2 * np.pi * radius
    places = np.array([oval(half, radius, d) for d in np.linspace(0, around, 4001)])
    step = np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1)
    np.testing.assert_allclose(step, around / 4000, rtol=1e-3)
    np.testing.assert_allclose(places[0, :2], places[-1, :2], atol=1e-9)
    # The heading turns the local x axis (cos, -sin in x and z) along the way.
    way = np.diff(places[:, :2], axis=0) / step[:, None]
    heading = places[:-1, 2] + np.diff(places[:, 2]) / 2
    mid = np.abs(np.diff(places[:, 2])) < 1.0
    np.testing.assert_allclose(way[mid], np.stack([np.cos(heading), -np.sin(heading)], 1)[mid], atol=2e-3)
