from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from supersampling.scenes.stk.placement import Placement, read_placement, world_transform


def irrlicht(degrees: tuple[float, float, float]) -> np.ndarray:
    """Irrlicht's setRotationDegrees as its source spells it out: row vectors, so transposed here."""
    cr, cp, cy = np.cos(np.radians(degrees))
    sr, sp, sy = np.sin(np.radians(degrees))
    rows = [
        [cp * cy, cp * sy, -sp],
        [sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp],
        [cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp],
    ]
    return np.array(rows).T


def test_a_still_node_turns_as_irrlicht_turns_it() -> None:
    for degrees in ((30.0, 0.0, 0.0), (0.0, 40.0, 0.0), (0.0, 0.0, 50.0), (-79.0, 148.6, 18.3)):
        matrix = Placement(degrees=degrees).matrix()
        np.testing.assert_allclose(matrix[:3, :3], irrlicht(degrees), atol=1e-12)


def test_an_animated_node_turns_about_x_then_z_then_y() -> None:
    node = fromstring(
        '<object hpr="0 90 0"><curve channel="RotX" interpolation="linear" extend="const">'
        '<p c="1 90"/><p c="26 90"/></curve>'
        '<curve channel="RotZ" interpolation="linear" extend="const"><p c="1 90"/><p c="26 90"/></curve></object>'
    )
    # About x: y to z, z to -y. About z: x to y, y to -x. About y: z to x, x to -z. So x to y; y to z to x; z to -y to x
    # to -z.
    expected = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    np.testing.assert_allclose(read_placement(node).matrix(0.4)[:3, :3], expected, atol=1e-12)


def test_scale_comes_before_rotation_and_position_last() -> None:
    node = fromstring('<static-object xyz="10 20 30" hpr="0 0 90" scale="2 3 4"/>')
    point = read_placement(node).matrix() @ np.array([1.0, 1.0, 1.0, 1.0])
    # (2, 3, 4) turned a quarter about z is (-3, 2, 4).
    np.testing.assert_allclose(point, [7.0, 22.0, 34.0, 1.0], atol=1e-12)


def test_a_child_moves_in_its_parents_frame_and_the_world_is_mirrored() -> None:
    parent = read_placement(fromstring('<library xyz="100 0 0" hpr="0 90 0" scale="2 2 2"/>'))
    child = read_placement(fromstring('<object xyz="0 0 5"/>'))
    transform = world_transform((parent, child))
    assert not callable(transform)
    # Game space: (1, 0, 5) doubled is (2, 0, 10); about y, z to x and x to -z: (10, 0, -2); at (110, 0, -2). Here z is
    # -z, so the game's (1, 0, 0) is ours too, and the result's z is 2.
    np.testing.assert_allclose(transform @ np.array([1.0, 0.0, 0.0, 1.0]), [110.0, 0.0, 2.0, 1.0], atol=1e-5)
    # A rotation stays a rotation: no mirror is left in the matrix.
    assert np.linalg.det(transform[:3, :3]) == pytest.approx(8.0, rel=1e-5)


def test_motion_of_any_node_of_the_chain_makes_a_function_of_time() -> None:
    curve = '<curve channel="LocZ" interpolation="linear" extend="cyclic"><p c="1 0"/><p c="51 8"/></curve>'
    parent = read_placement(fromstring(f'<library xyz="1 2 3">{curve}</library>'))
    transform = world_transform((parent, Placement(position=(5.0, 0.0, 0.0))))
    assert callable(transform)
    # 8 m in 2 s; the position's x and y stay those of the attributes.
    np.testing.assert_allclose(transform(0.5)[:3, 3], [6.0, 2.0, -2.0], atol=1e-6)
    np.testing.assert_allclose(transform(2.5)[:3, 3], [6.0, 2.0, -2.0], atol=1e-6)


def test_the_old_syntax_places_too() -> None:
    assert read_placement(fromstring('<object x="1" y="2" z="3" h="45"/>')) == Placement(
        (1.0, 2.0, 3.0), (0.0, 45.0, 0.0)
    )
