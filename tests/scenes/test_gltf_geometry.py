"""Accessors, primitives and the node hierarchy against arrays worked out by hand."""

import struct
from pathlib import Path

import numpy as np
import pytest
from gltf_files import SQUARE, SQUARE_INDICES, SQUARE_UV, Builder

from supersampling.scenes.gltf import load_gltf
from supersampling.scenes.scene import Mesh, Object, Scene


def placed(scene: Scene, item: Object, seconds: float = 0.0) -> np.ndarray:
    """World positions ``(N, 3)`` of an object's first mesh."""
    matrix = item.at(seconds)
    return scene.meshes[item.meshes[0]].positions @ matrix[:3, :3].T + matrix[:3, 3]


def corners(mesh: Mesh) -> np.ndarray:
    """``(M, 3, 3)`` corners of the triangles."""
    return mesh.positions[mesh.triangles]


def only_mesh(file: Builder, path: Path) -> Mesh:
    (mesh,) = load_gltf(file.glb(path / "a.glb")).meshes
    return mesh


def test_containers_hold_the_same_scene(tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.square())
    scenes = [
        load_gltf(file.glb(tmp_path / "a.glb")),
        load_gltf(file.gltf(tmp_path / "b.gltf")),
        load_gltf(file.gltf(tmp_path / "c.gltf", uri="my own.bin")),
    ]
    for scene in scenes:
        (mesh,) = scene.meshes
        np.testing.assert_array_equal(
            corners(mesh), np.array(SQUARE, np.float32)[np.array(SQUARE_INDICES)].reshape(2, 3, 3)
        )
        assert len(scene.routes) >= 12
        assert scene.near < scene.far


def test_matrices_and_parts_multiply_down_the_hierarchy(tmp_path: Path) -> None:
    file = Builder()
    half = np.sqrt(0.5)
    # Parent: 90 degrees about y, then moved; child: column-major matrix that doubles x and moves by 3 along y.
    child = file.node(mesh=file.square(), matrix=[2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1])
    file.node(children=[child], translation=[10, 0, 0], rotation=[0, half, 0, half], scale=[1, 1, 4])
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    (item,) = scene.objects
    x, y, z = np.array(SQUARE).T
    # x -> 2x; scale z by 4 (z = 0); a quarter turn about y takes +x to -z; then x + 10.
    np.testing.assert_allclose(placed(scene, item), np.stack([10 + 4 * z, y + 3, -2 * x], axis=1), atol=1e-5)
    assert not item.moves


def test_default_scene_is_taken_and_its_meshes_are_shared(tmp_path: Path) -> None:
    file = Builder()
    mesh = file.square()
    for x in (0, 5, 20):
        file.node(mesh=mesh, translation=[x, 0, 0])
    file.json |= {"scenes": [{"nodes": [2]}, {"nodes": [0, 1]}], "scene": 1}
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    assert [float(item.at(0.0)[0, 3]) for item in scene.objects] == [0.0, 5.0]
    assert len(scene.meshes) == 1
    assert scene.objects[0].meshes == scene.objects[1].meshes


@pytest.mark.parametrize("dtype", ["u1", "u2", "u4"])
def test_indices_of_every_size(dtype: str, tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.mesh({"POSITION": file.accessor(SQUARE)}, indices=file.accessor([1, 2, 3], dtype)))
    np.testing.assert_array_equal(corners(only_mesh(file, tmp_path)), [[SQUARE[1], SQUARE[2], SQUARE[3]]])


def test_strips_and_fans_keep_their_winding(tmp_path: Path) -> None:
    zigzag = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0], [0, 2, 0], [1, 2, 0]], float)
    ring = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 2, 0], [0, 2, 0]], float)
    file = Builder()
    file.node(
        mesh=file.mesh({"POSITION": file.accessor(zigzag)}, mode=5, indices=file.accessor([0, 1, 2, 3, 4, 4], "u2"))
    )
    file.node(mesh=file.mesh({"POSITION": file.accessor(ring)}, mode=6))
    strip, fan = load_gltf(file.glb(tmp_path / "a.glb")).meshes
    # By hand: every triangle of both turns counter-clockwise; the strip's last one has no area and is gone.
    assert len(strip.triangles) == 3
    assert len(fan.triangles) == 3
    areas = []
    for mesh in (strip, fan):
        a, b, c = np.moveaxis(corners(mesh).astype(float), 1, 0)
        areas.append(0.5 * np.cross(b - a, c - a)[:, 2])
    np.testing.assert_allclose(areas[0], [0.5, 0.5, 0.5])
    np.testing.assert_allclose(areas[1].sum(), 3.5)  # the shoelace area of the ring
    assert (areas[1] > 0.0).all()


def test_missing_normals_are_flat_and_missing_uv_zero(tmp_path: Path) -> None:
    roof = [[-1, 0, 0], [0, 1, 0], [0, 1, 2], [-1, 0, 2], [1, 0, 0], [1, 0, 2]]
    file = Builder()
    sides = file.accessor([0, 3, 2, 0, 2, 1, 1, 2, 5, 1, 5, 4], "u1")
    file.node(mesh=file.mesh({"POSITION": file.accessor(roof)}, indices=sides))
    mesh = only_mesh(file, tmp_path)
    half = np.sqrt(0.5)
    expected = np.repeat([[-half, half, 0.0], [half, half, 0.0]], 6, axis=0)
    np.testing.assert_allclose(mesh.normals[mesh.triangles.ravel()], expected, atol=1e-6)
    assert not mesh.uv.any()


def test_points_and_lines_are_left_out_with_a_warning(tmp_path: Path) -> None:
    file = Builder()
    positions = {"POSITION": file.accessor(SQUARE)}
    file.add("meshes", {"primitives": [{"attributes": positions, "mode": mode} for mode in (0, 1, 2, 3, 4)]})
    file.node(mesh=0)
    with pytest.warns(UserWarning, match=r"points and lines are left out \(4 times\)"):
        scene = load_gltf(file.glb(tmp_path / "a.glb"))
    assert len(scene.meshes) == 1


def test_interleaved_and_normalised_attributes(tmp_path: Path) -> None:
    file = Builder()
    rows = b""
    for (x, y, z), (u, v) in zip(SQUARE, SQUARE_UV):
        # position, normal of signed bytes (and padding), uv of unsigned shorts, colour of bytes
        rows += struct.pack(
            "<3f4b2H4B", x, y, z, 0, -127, 0, 0, round(u * 65535), round(v * 65535 / 3), 255, 51, 0, 255
        )
    view = file.view(rows, byteStride=24)
    layout = (
        ("POSITION", 0, 5126, "VEC3"),
        ("NORMAL", 12, 5120, "VEC3"),
        ("TEXCOORD_0", 16, 5123, "VEC2"),
        ("COLOR_0", 20, 5121, "VEC4"),
    )
    attributes = {
        name: file.add(
            "accessors",
            {
                "bufferView": view, "byteOffset": offset, "componentType": component, "normalized": component != 5126,
                "count": 4, "type": kind,
            },
        )
        for name, offset, component, kind in layout
    }  # fmt: skip
    file.node(mesh=file.mesh(attributes, indices=file.accessor(SQUARE_INDICES, "u1")))
    mesh = only_mesh(file, tmp_path)
    np.testing.assert_array_equal(mesh.positions, np.array(SQUARE, np.float32))
    np.testing.assert_allclose(mesh.normals, np.tile([0.0, -1.0, 0.0], (4, 1)), atol=1e-6)
    np.testing.assert_allclose(mesh.uv, np.array(SQUARE_UV) * [1.0, 1 / 3], atol=1e-5)
    assert mesh.colors is not None
    np.testing.assert_allclose(mesh.colors, np.tile([1.0, 0.2, 0.0], (4, 1)), atol=1e-6)


def test_quantised_positions(tmp_path: Path) -> None:
    file = Builder()
    quantised = np.round(np.array(SQUARE) * 32767)
    positions = file.accessor(quantised, "i2", normalized=True)
    file.node(mesh=file.mesh({"POSITION": positions}, indices=file.accessor(SQUARE_INDICES, "u1")))
    file.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    expected = np.array(SQUARE, np.float32)[np.array(SQUARE_INDICES)].reshape(2, 3, 3)
    np.testing.assert_allclose(corners(only_mesh(file, tmp_path)), expected, atol=1e-6)


@pytest.mark.parametrize("based", [True, False])
def test_sparse_accessors_replace_some_elements(based: bool, tmp_path: Path) -> None:
    file = Builder()
    sparse = {
        "count": 2,
        "indices": {"bufferView": file.view(struct.pack("<2H", 1, 2)), "componentType": 5123},
        "values": {"bufferView": file.view(struct.pack("<6f", 5, 0, 0, 6, 7, 8))},
    }
    if based:
        positions = file.accessor(SQUARE, sparse=sparse)
    else:
        positions = file.add("accessors", {"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse})
    expected = np.array(SQUARE, np.float32) if based else np.zeros((4, 3), np.float32)
    expected[1:3] = [[5, 0, 0], [6, 7, 8]]
    file.node(mesh=file.mesh({"POSITION": positions}, indices=file.accessor([0, 1, 2, 1, 2, 3], "u2")))
    np.testing.assert_array_equal(corners(only_mesh(file, tmp_path)), expected[[[0, 1, 2], [1, 2, 3]]])


def test_primitives_of_one_large_buffer_keep_only_their_vertices(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(1000, 3))
    picked = np.array([900, 17, 901, 17, 901, 950])
    file = Builder()
    file.node(
        mesh=file.mesh(
            {"POSITION": file.accessor(points), "NORMAL": file.accessor(points)}, indices=file.accessor(picked, "u2")
        )
    )
    mesh = only_mesh(file, tmp_path)
    assert len(mesh.positions) == 4
    np.testing.assert_array_equal(corners(mesh), points.astype(np.float32)[picked].reshape(2, 3, 3))


def test_skins_are_drawn_at_rest(tmp_path: Path) -> None:
    """Two joints, bound a unit lower than they rest, move their vertices up by one and by two."""
    file = Builder()
    joints = file.accessor([[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]], "u1")
    weights = file.accessor([[1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [0.5, 0.5, 0, 0]])
    mesh = file.square(JOINTS_0=joints, WEIGHTS_0=weights)
    bind = np.tile(np.eye(4).ravel(), (2, 1))
    upper = file.node(translation=[0, 1, 0])
    lower = file.node(translation=[0, 1, 0], children=[upper])
    file.add("skins", {"joints": [lower, upper], "inverseBindMatrices": file.accessor(bind)})
    file.node(mesh=mesh, skin=0, translation=[100, 0, 0])  # which the specification says is ignored
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    moved = np.array(SQUARE) + np.array([[0, 1, 0], [0, 1, 0], [0, 2, 0], [0, 1.5, 0]])
    np.testing.assert_allclose(placed(scene, scene.objects[0]), moved, atol=1e-6)
    np.testing.assert_allclose(scene.meshes[0].normals, np.tile([0, 0, 1], (4, 1)), atol=1e-6)
    file.animate(lower, "translation", [0, 1], [[0, 1, 0], [0, 5, 0]])
    with pytest.warns(UserWarning, match="skinned meshes stay in their rest pose"):
        load_gltf(file.glb(tmp_path / "a.glb"))


@pytest.mark.parametrize(("side", "factor"), [(0.01, 50.0 / np.sqrt(2.0)), (1e4, 0.01 / np.sqrt(2.0))])
def test_tiny_and_huge_models_are_brought_to_size(side: float, factor: float, tmp_path: Path) -> None:
    """A square of half side s has the radius s sqrt(2), which becomes 0.5 or 100 m."""
    file = Builder()
    file.node(mesh=file.square(), scale=[side] * 3)
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    np.testing.assert_allclose(placed(scene, scene.objects[0]), np.array(SQUARE) * side * factor, rtol=1e-5)
