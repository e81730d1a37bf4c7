"""Mutated glTF files: each gives a scene of finite numbers or one sentence."""

import json
from pathlib import Path

import gltf_geometry_cases
import gltf_material_cases
import gltf_node_cases
import numpy as np
import pytest
from gltf_cases import CASES
from gltf_files import Builder, data_uri, glb_bytes
from scene_mutations import check_mutations, mutated_bytes, mutated_tree

from supersampling.scenes.gltf import fingerprint, load_gltf
from supersampling.scenes.scene import Scene

MODULES = (gltf_geometry_cases, gltf_material_cases, gltf_node_cases)  # which register the cases


def _file(random: np.random.Generator) -> tuple[dict, bytes]:
    """Return the JSON and the buffer of one of the small files of the features."""
    file = Builder()
    build = CASES[random.integers(len(CASES))].build
    build(*[file, Builder()][: build.__code__.co_argcount])
    head = file.complete()
    return ({**head, "buffers": [{"byteLength": len(file.blob)}]} if file.blob else head), file.blob


def mutation(seed: int) -> bytes:
    """Return a mutated ``.glb`` or ``.gltf`` file."""
    random = np.random.default_rng(seed)
    head, blob = _file(random)
    kind = random.integers(8)
    if kind < 6:
        head = mutated_tree(head, random)
    if kind in (5, 6):
        blob = mutated_bytes(blob, random)
    plain = not random.integers(4)
    if (
        plain
        and blob
        and isinstance(head.get("buffers"), list)
        and head["buffers"]
        and isinstance(head["buffers"][0], dict)
    ):
        head["buffers"][0]["uri"] = data_uri(blob)
    text = json.dumps(head).replace("Infinity", "1e999").encode()
    data = text if plain else glb_bytes(text, blob)
    return mutated_bytes(data, random) if kind == 7 else data


def check(scene: Scene) -> None:
    """Assert that a scene can be drawn: finite numbers, and indices that exist."""
    for mesh in scene.meshes:
        for values in (mesh.positions, mesh.normals, mesh.uv, mesh.colors, mesh.tangents):
            assert values is None or np.isfinite(values).all()
            assert values is None or len(values) == len(mesh.positions)
        assert mesh.triangles.max() < len(mesh.positions)
        assert mesh.material < len(scene.materials)
    for item in scene.objects:
        assert np.isfinite([item.at(t) for t in (0.0, 0.3, 1.7)]).all()
    for route in scene.routes:
        assert np.isfinite(route.points).all()
        assert route.recorded is None or np.isfinite([route.recorded(t) for t in (0.0, 0.3, 1.7)]).all()
    for light in scene.points:
        assert np.isfinite([*light.position, *light.intensity, light.radius, *light.direction]).all()
    for material in scene.materials:
        numbers = [*material.base_color, *material.emission, material.roughness, material.metallic]
        assert np.isfinite([*numbers, material.alpha_cutoff]).all()
    assert np.isfinite([scene.near, scene.far, *(scene.sun.radiance if scene.sun else ())]).all()
    assert 0.0 < scene.near < scene.far


@pytest.mark.slow
def test_mutated_files(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"

    def load(seed: int) -> None:
        path.write_bytes(mutation(seed))
        fingerprint(path)
        check(load_gltf(path))

    check_mutations(load, tmp_path)
