"""Numbers in a file that point nowhere or mean nothing, each told in one clear sentence."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from gltf_files import SQUARE, Builder, check_error, glb_bytes, square_file


def positions(file: Builder, **change: object) -> Builder:
    """With the first accessor, which holds the positions, changed."""
    file.json["accessors"][0] |= change
    return file


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"count": 5}, "ends at byte 60 of a buffer view of 48"),
        ({"byteOffset": 4}, "ends at byte 52 of a buffer view of 48"),
        ({"byteOffset": -4}, "byteOffset -4"),
        ({"count": 0}, "count 0"),
        ({"count": 1 << 40, "bufferView": None}, "count 1099511627776"),
        ({"componentType": 5130}, "component type 5130"),
        ({"type": "VEC7"}, "VEC7"),
        ({"type": "VEC2"}, "has 2 components instead of 3"),
        ({"bufferView": 99}, r"bufferViews\[99\]"),
    ],
)
def test_accessors_out_of_range(change: dict, words: str, tmp_path: Path) -> None:
    check_error(positions(square_file(), **change).glb(tmp_path / "a.glb"), words)


def test_views_and_sparse_elements_out_of_range(tmp_path: Path) -> None:
    file = square_file()
    file.json["bufferViews"][0]["byteLength"] = 10**6
    check_error(file.glb(tmp_path / "a.glb"), "Buffer view 0")
    file = square_file()
    file.json["bufferViews"][0]["byteStride"] = 4
    check_error(file.glb(tmp_path / "a.glb"), "Accessor 0")
    file = square_file()
    sparse = {"count": 1, "indices": {"bufferView": file.view(b"\x04"), "componentType": 5121}}
    positions(file, sparse={**sparse, "values": {"bufferView": file.view(bytes(12))}})
    check_error(file.glb(tmp_path / "a.glb"), "replaces element 4 of 4")


def test_indices_out_of_range(tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.mesh({"POSITION": file.accessor(SQUARE)}, indices=file.accessor([0, 1, 4], "u1")))
    check_error(file.glb(tmp_path / "a.glb"), "reach vertex 4 of 4")
    for kind, item in (("meshes", {"mesh": 7}), ("nodes", {"children": [7]}), ("cameras", {"mesh": 0, "camera": 7})):
        file = square_file()
        file.node(**item)
        check_error(file.glb(tmp_path / "a.glb"), rf"{kind}\[7\]")
    file = Builder()
    file.node(mesh=file.square(7))
    check_error(file.glb(tmp_path / "a.glb"), r"materials\[7\]")
    file = square_file()
    file.node(extensions={"KHR_lights_punctual": {"light": 0}})
    check_error(file.glb(tmp_path / "a.glb"), "light 0")
    file = square_file()
    file.animate(7, "scale", [0, 1], np.ones((2, 3)))
    check_error(file.glb(tmp_path / "a.glb"), r"nodes\[7\]")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_positions_that_are_not_finite(value: float, tmp_path: Path) -> None:
    broken = np.array(SQUARE)
    broken[2, 1] = value
    file = Builder()
    file.node(mesh=file.mesh({"POSITION": file.accessor(broken)}, indices=file.accessor([0, 1, 2], "u1")))
    check_error(file.glb(tmp_path / "a.glb"), "not finite")


def no_meshes() -> Builder:
    file = Builder()
    file.node()
    return file


def elsewhere() -> Builder:
    """A square, but not in the default scene."""
    file = square_file()
    file.json |= {"scenes": [{"nodes": []}, {"nodes": [0]}]}
    return file


def slivers() -> Builder:
    file = Builder()
    file.node(mesh=file.mesh({"POSITION": file.accessor(SQUARE)}, indices=file.accessor([0, 1], "u1")))
    return file


@pytest.mark.parametrize("make", [Builder, no_meshes, elsewhere, slivers])
def test_files_without_triangles(make: Callable[[], Builder], tmp_path: Path) -> None:
    check_error(make().glb(tmp_path / "a.glb"), "no triangles")


def test_nodes_that_are_no_trees(tmp_path: Path) -> None:
    file = square_file()
    file.node(children=[2])
    file.node(children=[1])
    file.json["scenes"] = [{"nodes": [0, 1]}]
    check_error(file.glb(tmp_path / "a.glb"), "own ancestor")
    file.json["scenes"] = []
    check_error(file.glb(tmp_path / "a.glb"), "cycle")
    file = square_file()
    file.node(children=[0])
    file.node(children=[0])
    check_error(file.glb(tmp_path / "a.glb"), "two parents")


@pytest.mark.parametrize(
    ("times", "count", "words"),
    [([1, 0], 2, "do not rise"), ([0, np.nan], 2, "do not rise"), ([0, 1], 3, "3 values for 2 keys")],
)
def test_broken_animations(times: list[float], count: int, words: str, tmp_path: Path) -> None:
    file = square_file()
    file.animate(0, "translation", times, np.ones((count, 3)))
    check_error(file.glb(tmp_path / "a.glb"), words)


def test_nodes_with_broken_numbers(tmp_path: Path) -> None:
    for part in ({"translation": [0, 1e999, 0]}, {"scale": [1, 1]}, {"matrix": [1] * 15}):
        file = Builder()
        file.node(mesh=file.square(), **part)
        path = file.glb(tmp_path / "a.glb")
        path.write_bytes(
            glb_bytes(
                json.dumps(file.complete() | {"buffers": [{"byteLength": len(file.blob)}]})
                .replace("Infinity", "1e999")
                .encode(),
                file.blob,
            )
        )
        check_error(path, f"Invalid {next(iter(part))} .* of node 0")
