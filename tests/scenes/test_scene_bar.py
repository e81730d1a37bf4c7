"""The bar is glossy nearly everywhere, lit only by small lamps and glowing surfaces; everything moves slowly."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.scenes.scene import Material, Scene

FRAME = 1.0 / 60.0


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("bar")


def _roughness(material: Material) -> float:
    """Return the median roughness over the material's surface."""
    share = 1.0 if material.surface is None else float(np.median(material.surface[..., 0])) / 255
    return material.roughness * share


def _area(scene: Scene) -> np.ndarray:
    """Return the square metres of each material."""
    area = np.zeros(len(scene.materials))
    for mesh in scene.meshes:
        p, q, r = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
        area[mesh.material] += 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1).sum()
    return area


def test_gloss_dominates(scene):
    rough, area = np.array([_roughness(m) for m in scene.materials]), _area(scene)
    assert area[rough <= 0.4].sum() > 0.95 * area.sum()
    assert area[rough <= 0.3].sum() > 0.5 * area.sum()
    assert any(
        m.metallic > 0.9 and _roughness(m) < 0.3 and m.surface[..., 1].min() > 250
        for m in scene.materials
        if m.surface is not None
    )


def test_lit_by_lamps_and_glowing_materials(scene):
    assert scene.sun is None
    assert 1 <= sum(p.shadowed for p in scene.points) <= 3
    assert sum(not p.shadowed for p in scene.points) >= 20
    assert sum(max(m.emission) > 1.0 for m in scene.materials) >= 8


def test_no_holes_no_interface_and_slow_motion(scene):
    assert all(m.alpha == "opaque" and not m.interface for m in scene.materials)
    for thing in (o for o in scene.objects if o.moves):
        points = np.concatenate([scene.meshes[i].positions for i in thing.meshes])
        points = np.concatenate([points, np.ones((len(points), 1))], 1).T
        paths = np.array([(thing.at(k * FRAME) @ points)[:3] for k in range(0, 600, 7)])
        after = np.array([(thing.at((k + 1) * FRAME) @ points)[:3] for k in range(0, 600, 7)])
        assert np.linalg.norm(after - paths, axis=1).max() < 0.04  # metres per frame: 2.4 m/s at a blade's tip
