"""The market is full of print and fine texture, has leaves with holes, and only a few slow objects move in it."""

import numpy as np
import pytest
from built_scenes import built

from supersampling.render.paths import split_routes
from supersampling.scenes.market.textures import fan_cobbles
from supersampling.scenes.scene import Scene

# Words in the names of the materials that carry print.
_PRINT = ("newspaper", "bill", "shop", "sign", "tags", "slate", "covers", "spines", "crate", "by-laws", "frieze")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return built("market")


def _triangles(scene: Scene, words: tuple[str, ...]) -> np.ndarray:
    """Return the corners ``(M, 3, 3)`` of static triangles whose material has one of these words in its name."""
    corners = [
        scene.meshes[m].positions[scene.meshes[m].triangles]
        for m in scene.objects[0].meshes
        if any(w in scene.materials[scene.meshes[m].material].name for w in words)
    ]
    return np.concatenate(corners).astype(np.float64)


@pytest.mark.parametrize("split", ["train", "val", "test"])
def test_print_is_near_every_route(scene: Scene, split: str) -> None:
    """At least 4 square metres of print are within 6 m of the middle of each route."""
    corners = _triangles(scene, _PRINT)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    for route in split_routes(scene, split):
        eye = np.asarray(route.points, np.float64).mean(axis=0)
        near = np.linalg.norm(corners.mean(axis=1) - eye, axis=1) < 6.0
        assert area[near].sum() > 4.0, route.name


def test_print_is_fine(scene: Scene) -> None:
    """Newspapers have more than 1,000 texels a metre: small type of 3 mm can be read from nearby."""
    for m in scene.objects[0].meshes:
        mesh, material = scene.meshes[m], scene.materials[scene.meshes[m].material]
        if material.name.startswith("newspaper"):
            assert material.albedo is not None
            p, uv = (mesh.positions[mesh.triangles].astype(np.float64), mesh.uv[mesh.triangles].astype(np.float64))
            a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
            texels = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() * material.albedo[..., 0].size
            metres = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
            assert np.sqrt(texels / metres) > 1000


def test_movers_are_few_and_slow(scene: Scene) -> None:
    movers = [o for o in scene.objects if o.moves]
    assert 5 <= len(movers) <= 20
    for thing in movers:
        points = np.concatenate([scene.meshes[m].positions for m in thing.meshes])
        for seconds in np.linspace(0, 60, 61):
            a, b = thing.at(seconds), thing.at(seconds + 1 / 60)
            step = points @ (b - a)[:3, :3].T + (b - a)[:3, 3]
            assert np.linalg.norm(step, axis=1).max() * 60 < 1.5  # metres per second


def test_nothing_shines_or_glows_and_leaves_have_holes(scene: Scene) -> None:
    for material in scene.materials:
        rough = material.roughness if material.surface is None else material.surface[..., 0].min() / 255
        assert rough > 0.6
        assert material.metallic == 0
        assert max(material.emission) == 0
    cut = [m for m in scene.materials if m.alpha == "test"]
    assert len(cut) >= 3
    for material in cut:
        assert material.albedo is not None
        assert 0.05 < (material.albedo[..., 3] < 128).mean() < 0.95


def test_fan_cobbles_repeat() -> None:
    """Steps across the tile's edge are like those inside it."""
    albedo = fan_cobbles(256, 1)[0].astype(float)
    for axis in (0, 1):
        inside = np.abs(np.diff(albedo, axis=axis)).mean()
        across = np.abs(albedo.take(0, axis) - albedo.take(-1, axis)).mean()
        assert across < 1.5 * inside
