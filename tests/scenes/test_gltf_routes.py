"""Where routes may go: surveys of closed shapes, and routes that keep out of walls."""

from pathlib import Path

import numpy as np
import pytest
from gltf_files import Builder

from supersampling.scenes.gltf import load_gltf
from supersampling.scenes.gltf.nodes import NodeTransform
from supersampling.scenes.gltf.survey import Survey, survey
from supersampling.scenes.scene import Mesh

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
# Each face counter-clockwise as seen from outside.
FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TRIANGLES = FACES[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def box(inward: bool = False) -> Mesh:
    triangles = TRIANGLES[:, ::-1] if inward else TRIANGLES
    empty = np.zeros((8, 3), np.float32)
    return Mesh(CORNERS.astype(np.float32), empty, empty[:, :2], triangles.astype(np.uint32), 0)


def surveyed(half: tuple[float, float, float], inward: bool) -> Survey:
    return survey([box(inward)], [((0,), NodeTransform((np.diag([*half, 1.0]),)))])


@pytest.mark.parametrize("inward", [False, True])
def test_solids_and_rooms_are_told_apart(inward: bool) -> None:
    found = surveyed((5.0, 2.0, 3.0), inward)
    within = np.array([[0, 0, 0], [3, 1, -1], [-4, 0, 2]], float)
    without = np.array([[7, 0, 0], [0, 4, 0], [20, 20, 20]], float)
    np.testing.assert_array_equal(found.backs_seen(within), 0.0 if inward else 1.0)
    # From outside the near walls hide the far ones, save where a tile reaches beyond the edge.
    assert (np.abs(found.backs_seen(without) - float(inward)) < 0.3).all()


def test_samples_are_spread_by_area() -> None:
    found = surveyed((5.0, 2.0, 3.0), False)
    assert found.area == pytest.approx(8.0 * (5 * 2 + 2 * 3 + 3 * 5))
    top = (np.abs(found.surface[:, 1] - 2.0) < 1e-9).mean()
    assert top == pytest.approx(5 * 3 / (2 * (5 * 2 + 2 * 3 + 3 * 5)), abs=0.01)
    np.testing.assert_allclose(found.surface[found.normals[:, 0] > 0.9].mean(axis=0), [5.0, 0.0, 0.0], atol=0.1)
    np.testing.assert_allclose(found.clearance(np.zeros((1, 3))), 2.0, atol=0.02)
    np.testing.assert_allclose((found.lo, found.hi), [(-5, -2, -3), (5, 2, 3)])


def test_bounds_hold_what_moves() -> None:
    def moved(seconds: float) -> np.ndarray:
        matrix = np.eye(4)
        matrix[0, 3] = 10.0 * np.sin(np.pi * seconds)
        return matrix

    found = survey([box()], [((0,), NodeTransform((moved,)))])
    np.testing.assert_allclose((found.lo, found.hi), [(-11, -1, -1), (11, 1, 1)], atol=0.1)


def place(file: Builder, half: tuple[float, float, float], centre: tuple[float, float, float], inward: bool) -> None:
    indices = (TRIANGLES[:, ::-1] if inward else TRIANGLES).ravel()
    mesh = file.mesh({"POSITION": file.accessor(CORNERS)}, indices=file.accessor(indices, "u1"))
    file.node(mesh=mesh, scale=list(half), translation=list(centre))


@pytest.mark.parametrize("block", [(1.5, 2.0, 1.5), (8.0, 2.0, 3.0)])
def test_routes_in_a_room_keep_out_of_a_block(block: tuple[float, float, float], tmp_path: Path) -> None:
    file = Builder()
    place(file, (10.0, 2.0, 6.0), (0.0, 2.0, 0.0), inward=True)
    place(file, block, (1.0, 2.0, 0.0), inward=False)
    scene = load_gltf(file.glb(tmp_path / "room.glb"))
    inside = [r.points for r in scene.routes if r.name.startswith(("walk", "turn"))]
    assert len(inside) >= 6
    points = np.concatenate(inside)
    assert (np.abs(points) < [10.0, 4.0, 6.0]).all()
    assert (points[:, 1] > 0.0).all()
    assert (np.abs(points - [1.0, 2.0, 0.0]) > block)[:, [0, 2]].any(axis=1).all()
    # At the eye's height above the floor.
    np.testing.assert_allclose(inside[0][:, 1], 1.6, atol=1e-6)


def test_halls_without_an_outside_are_seen_from_within(tmp_path: Path) -> None:
    """Many rooms' worth of walks are there, so that none of the routes looks at the backs of the walls."""
    for inward, outside in ((True, False), (False, True)):
        file = Builder()
        place(file, (30.0, 6.0, 30.0), (0.0, 6.0, 0.0), inward)
        scene = load_gltf(file.glb(tmp_path / "hall.glb"))
        for route in scene.routes:
            assert (np.abs(route.points - [0.0, 6.0, 0.0]) > [30.0, 6.0, 30.0]).any() == outside


def test_routes_around_an_object_stay_outside(tmp_path: Path) -> None:
    file = Builder()
    place(file, (0.5, 0.4, 0.6), (7.0, 0.0, 0.0), inward=False)
    scene = load_gltf(file.glb(tmp_path / "object.glb"))
    for route in scene.routes:
        assert (np.abs(route.points - [7.0, 0.0, 0.0]) > [0.5, 0.4, 0.6]).any(axis=1).all()
        assert route.focus is not None
        np.testing.assert_allclose(route.focus.mean(axis=0), [7.0, 0.0, 0.0], atol=1e-5)
