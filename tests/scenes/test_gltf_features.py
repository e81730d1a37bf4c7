"""Each row of docs/gltf.md: the feature looks like a plain file without it, or a warning or an error names it."""

import re
import warnings
from pathlib import Path

import gltf_geometry_cases
import gltf_material_cases
import gltf_node_cases
import numpy as np
import pytest
from gltf_cases import CASES, Case
from gltf_files import Builder, check_error, square_file

from supersampling.render.gpu_scene import tangents
from supersampling.scenes.gltf import load_gltf
from supersampling.scenes.gltf.features import (
    DRAWN_EXTENSIONS,
    IGNORED_EXTENSIONS,
    NEUTRAL_EXTENSIONS,
    Deviation,
    ignored_extension,
)
from supersampling.scenes.scene import Material, Scene

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "gltf.md").read_text()
ROWS = dict(re.findall(r"^\| (.+?) \| (.+?) \|$", PAGE, re.MULTILINE))
MODULES = (gltf_geometry_cases, gltf_material_cases, gltf_node_cases)  # which register the cases


def surfaces(scene: Scene, seconds: float) -> list[tuple[Material, dict[str, np.ndarray]]]:
    """Return the material of each mesh of each object, and what its triangles' corners have, in the world."""
    out = []
    for item in scene.objects:
        matrix = item.at(seconds)
        for mesh in (scene.meshes[number] for number in item.meshes):
            corners = mesh.triangles.ravel()
            material = scene.materials[mesh.material]
            maps = [material.albedo, material.normal, material.surface, material.glow]
            values = {"positions": mesh.positions[corners] @ matrix[:3, :3].T + matrix[:3, 3]}
            values["normals"] = mesh.normals[corners] @ np.linalg.inv(matrix[:3, :3])
            if any(image is not None for image in maps):
                values["uv"] = mesh.uv[corners]
            if material.normal is not None:
                values["tangents"] = (tangents(mesh) if mesh.tangents is None else mesh.tangents)[corners]
            values["colors"] = np.ones((1, 3)) if mesh.colors is None else mesh.colors[corners]
            out.append((material, values))
    return out


def check_materials(first: Material, second: Material) -> None:
    for name in ("base_color", "roughness", "metallic", "emission", "alpha_cutoff"):
        np.testing.assert_allclose(getattr(first, name), getattr(second, name), err_msg=name)
    for name in ("alpha", "double_sided", "sampling", "colored_emission"):
        assert getattr(first, name) == getattr(second, name)
    for name in ("albedo", "normal", "surface", "glow"):
        images = [getattr(first, name), getattr(second, name)]
        assert (images[0] is None) == (images[1] is None)
        if images[0] is not None:
            np.testing.assert_allclose(images[0].astype(int), images[1], atol=1)


def check_same(first: Scene, second: Scene) -> None:
    """Assert that both scenes look the same at two instants."""
    for seconds in (0.0, 0.7):
        pairs = list(zip(surfaces(first, seconds), surfaces(second, seconds), strict=True))
        for (material, values), (expected_material, expected) in pairs:
            check_materials(material, expected_material)
            assert values.keys() == expected.keys()
            for name, value in expected.items():
                np.testing.assert_allclose(values[name], value, atol=2e-6, err_msg=name)
    views = [[(r.name, r.fov, r.recorded(0.7).tolist()) for r in s.routes if r.recorded] for s in (first, second)]
    assert views[0] == views[1]
    np.testing.assert_allclose(*([v for p in s.points for v in (*p.intensity, p.radius)] for s in (first, second)))
    assert [p.cone for p in first.points] == [p.cone for p in second.points]
    assert first.sun == second.sun


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.row)
def test_row(case: Case, tmp_path: Path) -> None:
    file, plain = Builder(), Builder()
    if case.error:
        case.build(file)
        check_error(file.glb(tmp_path / "a.glb"), case.error)
        return
    if case.warning:
        case.build(file)
        with pytest.warns(UserWarning, match=re.escape(case.warning)) as caught:
            load_gltf(file.glb(tmp_path / "a.glb"))
        assert [w.category for w in caught].count(UserWarning) == 1
        return
    case.build(file, plain)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        check_same(load_gltf(file.glb(tmp_path / "a.glb")), load_gltf(plain.glb(tmp_path / "b.glb")))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.row)
def test_the_page_says_what_becomes_of_a_feature(case: Case) -> None:
    answer = ROWS[case.row]
    assert answer.startswith("refused" if case.error else "warning" if case.warning else "drawn")
    assert f'"{case.warning}"' in answer or not case.warning


def test_the_page_has_a_row_for_each_feature_and_extension() -> None:
    names = {name.strip("`") for name in ROWS} - {"feature", "extension", "---"}
    extensions = DRAWN_EXTENSIONS | NEUTRAL_EXTENSIONS | set(IGNORED_EXTENSIONS)
    assert names == {case.row.strip("`") for case in CASES} | extensions
    assert {case.warning for case in CASES} - {""} == {deviation.value for deviation in Deviation}


@pytest.mark.parametrize("name", [*sorted(IGNORED_EXTENSIONS), "ACME_fog"])
def test_an_ignored_extension_is_named_with_its_effect(name: str, tmp_path: Path) -> None:
    assert name == "ACME_fog" or ROWS[f"`{name}`"] == IGNORED_EXTENSIONS[name]
    listed, used, required = square_file(), square_file(), square_file()
    listed.json["extensionsUsed"] = [name]
    used.json["nodes"][0]["extensions"] = {name: {}}
    for file in (listed, used):
        with pytest.warns(UserWarning, match=re.escape(ignored_extension(name))):
            load_gltf(file.glb(tmp_path / "a.glb"))
    required.json["extensionsRequired"] = [name]
    check_error(required.glb(tmp_path / "a.glb"), f"requires the unsupported glTF extension {name}")


@pytest.mark.parametrize("name", sorted(DRAWN_EXTENSIONS | NEUTRAL_EXTENSIONS))
def test_a_supported_extension_may_be_required(name: str, tmp_path: Path) -> None:
    assert ROWS[f"`{name}`"] == ("drawn" if name in DRAWN_EXTENSIONS else "does not change the picture")
    file = square_file()
    file.json |= {"extensionsUsed": [name], "extensionsRequired": [name]}
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        load_gltf(file.glb(tmp_path / "a.glb"))


def test_a_mesh_that_exists_only_compressed_is_refused(tmp_path: Path) -> None:
    file = square_file()
    del file.json["accessors"][0]["bufferView"]
    file.json["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    check_error(file.glb(tmp_path / "a.glb"), "stored only with KHR_draco_mesh_compression")
