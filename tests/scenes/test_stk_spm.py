from itertools import product
from pathlib import Path

import numpy as np
import pytest
from stk_files import WALL, WALL_INDICES, Vertex, spm_bytes

from supersampling.errors import UserError
from supersampling.scenes.stk.spm import read_spm

FLAGS = list(product((False, True), repeat=4))


def written(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "mesh.spm"
    path.write_bytes(data)
    return path


def random_vertices(count: int, colours: str) -> list[Vertex]:
    rng = np.random.default_rng(3)
    vertices = []
    for k in range(count):
        x, y, z = (int(v) for v in rng.integers(-400, 401, size=3))
        coloured = colours == "all" or (colours == "mixed" and k % 3 == 1)
        vertices.append(
            Vertex(
                position=tuple(float(np.float32(v)) for v in rng.normal(size=3)),
                normal=(x, y, z or 1),
                color=tuple(int(v) for v in rng.integers(0, 256, size=3)) if coloured else None,
                uv=tuple(float(np.float16(v)) for v in rng.normal(size=2)),
                uv2=tuple(float(np.float16(v)) for v in rng.normal(size=2)),
            )
        )
    return vertices


@pytest.mark.parametrize("textures", [("", ""), ("a.png", ""), ("a.png", "b.png")])
@pytest.mark.parametrize(("normals", "colors", "tangents", "skinned"), FLAGS)
def test_every_combination_of_fields_comes_back_as_it_was_written(
    tmp_path: Path, textures: tuple[str, str], normals: bool, colors: bool, tangents: bool, skinned: bool
) -> None:
    vertices = random_vertices(7, "mixed")
    indices = [0, 1, 2, 3, 4, 5, 6, 0, 5]
    # Two buffers, so that one that ends in the wrong place spoils the next.
    data = spm_bytes(
        [(vertices, indices, textures)] * 2, normals=normals, colors=colors, tangents=tangents, skinned=skinned
    )
    buffers = read_spm(written(tmp_path, data))
    assert len(buffers) == 2
    for buffer in buffers:
        assert buffer.textures == textures
        np.testing.assert_array_equal(buffer.positions, np.array([v.position for v in vertices], np.float32))
        np.testing.assert_array_equal(buffer.triangles, np.array(indices).reshape(-1, 3))
        np.testing.assert_allclose(np.linalg.norm(buffer.normals, axis=1), 1.0, atol=1e-6)
        if normals:
            expected = np.array([v.normal for v in vertices], np.float64)
            expected /= np.linalg.norm(expected, axis=1, keepdims=True)
            np.testing.assert_allclose(buffer.normals, expected, atol=1e-6)
        if textures[0]:
            assert buffer.uv is not None
            np.testing.assert_array_equal(buffer.uv, np.array([v.uv for v in vertices], np.float32))
        else:
            assert buffer.uv is None
        if colors:
            np.testing.assert_array_equal(buffer.colors, np.array([v.color or (255, 255, 255) for v in vertices]))
        else:
            assert buffer.colors is None


@pytest.mark.parametrize("colours", ["none", "all", "mixed"])
@pytest.mark.parametrize("count", [255, 256, 300])
def test_indices_are_bytes_up_to_255_vertices(tmp_path: Path, colours: str, count: int) -> None:
    vertices = random_vertices(count, colours)
    indices = [0, count - 1, count // 2]
    (buffer,) = read_spm(written(tmp_path, spm_bytes([(vertices, indices, ("a.png", ""))], colors=True)))
    np.testing.assert_array_equal(buffer.triangles, [indices])
    np.testing.assert_array_equal(buffer.uv, np.array([v.uv for v in vertices], np.float32))
    expected = [v.color or (255, 255, 255) for v in vertices]
    np.testing.assert_array_equal(expected if buffer.colors is None else buffer.colors, expected)
    assert (buffer.colors is None) == (colours == "none")


def test_missing_normals_are_those_of_clockwise_faces(tmp_path: Path) -> None:
    (buffer,) = read_spm(written(tmp_path, spm_bytes([(WALL, WALL_INDICES, ("", ""))], normals=False)))
    np.testing.assert_allclose(buffer.normals, np.tile([0.0, 0.0, -1.0], (4, 1)), atol=1e-6)


def test_a_file_cut_short_at_any_byte_is_refused_in_one_sentence(tmp_path: Path) -> None:
    vertices = random_vertices(3, "all")
    whole = spm_bytes([(vertices, (0, 1, 2), ("a.png", ""))], colors=True, tangents=True)
    for length in range(len(whole)):
        with pytest.raises(UserError, match=r"mesh\.spm is not a valid \.spm mesh"):
            read_spm(written(tmp_path, whole[:length]))


def test_another_version_is_refused(tmp_path: Path) -> None:
    data = bytearray(spm_bytes([(WALL, WALL_INDICES, ("", ""))]))
    data[2] = 2 << 3 | 2
    with pytest.raises(UserError, match="its version is 2"):
        read_spm(written(tmp_path, bytes(data)))
