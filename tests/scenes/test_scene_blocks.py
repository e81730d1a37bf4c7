"""Shapes, motions and textures against closed forms."""

import numpy as np
import pytest

from supersampling.scenes.kit.motion import chain, rotation, shuttle, spin, sway
from supersampling.scenes.kit.shapes import (
    Shape,
    beam,
    box,
    cylinder,
    grid,
    join,
    lathe,
    panel,
    plate,
    quad,
    sphere,
    tube,
)
from supersampling.scenes.kit.textures import floor_tiles, fractal, masonry, normals, photo


def _corners(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    a, b, c = (shape.positions[shape.triangles[:, k]] for k in range(3))
    return a, b, c


def _area(shape: Shape) -> float:
    a, b, c = _corners(shape)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _volume(shape: Shape) -> float:
    """Divergence theorem: positive only when the faces are counter-clockwise from outside."""
    a, b, c = _corners(shape)
    return float((a * np.cross(b, c)).sum() / 6)


def _agreement(shape: Shape) -> float:
    a, b, c = _corners(shape)
    mean = shape.normals[shape.triangles].mean(axis=1)
    return float(((np.cross(b - a, c - a) * mean).sum(axis=1) > 0).mean())


def test_box_area_and_volume() -> None:
    shape = box((2.0, 3.0, 5.0), (7.0, -1.0, 4.0))
    assert _area(shape) == pytest.approx(2 * (6 + 10 + 15))
    assert _volume(shape) == pytest.approx(30.0)
    np.testing.assert_allclose((shape.positions.min(0), shape.positions.max(0)), ((6, -2.5, 1.5), (8, 0.5, 6.5)))


def test_volume_of_cylinder_sphere_and_tube() -> None:
    polygon = 0.5 * 12 * np.sin(2 * np.pi / 12)  # of radius 1
    assert _volume(cylinder(0.5, 2.0, 12)) == pytest.approx(polygon * 0.25 * 2.0)
    assert _volume(sphere(2.0, 96)) == pytest.approx(4 / 3 * np.pi * 8, rel=0.005)
    # A closed ring by Pappus: area of the hexagon times the way of its middle (a polygon of 64 sides).
    angle = np.linspace(0, 2 * np.pi, 65)[:-1]
    ring = tube(np.stack([3 * np.cos(angle), 3 * np.sin(angle), 0 * angle], 1), 0.2, 6, closed=True)
    assert _volume(ring) == pytest.approx(0.5 * 6 * np.sin(np.pi / 3) * 0.04 * 2 * np.pi * 3, rel=0.01)


def test_plate_with_a_hole_and_beam() -> None:
    angle = np.linspace(0, 2 * np.pi, 41)[:-1]
    rim = np.stack([np.cos(angle), np.sin(angle)], 1)
    polygon = 0.5 * 40 * np.sin(2 * np.pi / 40)
    assert _volume(plate(rim * 2, rim, 0.3, closed=True)) == pytest.approx(polygon * (4 - 1) * 0.3)
    bar = beam((1, 2, 3), (4, 6, 3), 0.1, 0.2)
    assert _volume(bar) == pytest.approx(5 * 0.02)
    np.testing.assert_allclose(bar.positions.mean(0), (2.5, 4, 3), atol=1e-12)


@pytest.mark.parametrize(
    "shape",
    [
        box((1, 2, 3)),
        cylinder(0.5, 1.0),
        sphere(1.0),
        lathe([(0.3, 2.0), (0.35, 0.0)], 96, 12, 0.1),
        tube([(0, 0, 0), (0, 1, 0), (1, 2, 0)], 0.1),
        beam((0, 0, 0), (1, 1, 1), 0.1),
        quad((0, 0, 0), (1, 0, 0), (0, 0, 1)),
    ],
    ids=["box", "cylinder", "sphere", "fluted", "tube", "beam", "quad"],
)
def test_normals_are_unit_and_on_the_front(shape: Shape) -> None:
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1.0, atol=1e-9)
    assert _agreement(shape) == 1.0


def test_flutes_are_cut_to_their_depth() -> None:
    radius = np.hypot(*lathe([(0.5, 1.0), (0.5, 0.0)], 80, 20, 0.1).positions[:, ::2].T)
    assert radius.max() == pytest.approx(0.5)
    assert radius.min() == pytest.approx(0.45)


def test_quad_uv_run_right_and_down_and_panel_uv_are_metres() -> None:
    flat = quad((1, 5, 0), (4, 0, 0), (0, -2, 0), (2, 4))
    np.testing.assert_allclose(flat.uv[:, 0], (flat.positions[:, 0] - 1) / 4)
    np.testing.assert_allclose(flat.uv[:, 1], (5 - flat.positions[:, 1]) / 2)
    np.testing.assert_allclose(flat.normals, np.broadcast_to((0, 0, 1), flat.normals.shape))
    left, right = panel((0, 3, 0), (2, 0, 0), (0, -3, 0)), panel((2, 3, 0), (2, 0, 0), (0, -3, 0))
    assert np.ptp(left.uv[:, 0]) == pytest.approx(2)
    assert np.ptp(left.uv[:, 1]) == pytest.approx(3)
    assert left.uv[:, 0].max() == pytest.approx(right.uv[:, 0].min())


def test_grid_drops_empty_triangles_and_join_offsets_indices() -> None:
    points = np.zeros((2, 3, 3))
    points[1] = [(-1, -1, 0), (0, -1, 0), (1, -1, 0)]  # a fan from one point
    fan = grid(points, np.broadcast_to((0.0, 0, 1), points.shape), np.zeros((2, 3, 2)))
    assert len(fan.triangles) == 2
    assert _area(fan) == pytest.approx(1.0)
    pair = join([fan, fan.shift(9, 0, 0)])
    assert _area(pair) == pytest.approx(2.0)
    assert pair.triangles.max() == 11


def test_turn_y_is_counter_clockwise_from_above() -> None:
    turned = quad((-1, 1, 0), (2, 0, 0), (0, -2, 0)).turn_y(90)
    np.testing.assert_allclose(turned.normals, np.broadcast_to((1, 0, 0), turned.normals.shape), atol=1e-12)


def test_rotation_by_hand() -> None:
    quarter = rotation((0, 0, 2), np.pi / 2)[:3, :3]
    np.testing.assert_allclose(quarter @ (1, 0, 0), (0, 1, 0), atol=1e-12)
    third = rotation((1, 1, 1), 2 * np.pi / 3)[:3, :3]  # carries x to y to z
    np.testing.assert_allclose(third, [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-12)


def test_periods_and_extremes_of_the_motions() -> None:
    turn = spin((1, 2, 3), (0, 1, 0), 0.25)
    np.testing.assert_allclose(turn(0.7), turn(4.7), atol=1e-5)
    np.testing.assert_allclose(turn(1.0) @ (1, 0, 0, 1), (1, 2, 2, 1), atol=1e-5)  # a quarter turn takes x to -z
    swing = sway((0, 5, 0), (0, 0, 1), 30, 0.5)
    np.testing.assert_allclose(swing(0.5) @ (0, -2, 0, 1), (1.0, 5 - np.sqrt(3), 0, 1), atol=1e-5)
    trip = shuttle((-2, 0, 1), (4, 0, 1), 0.1)
    for seconds, x in ((0, -2), (2.5, 1), (5, 4), (10, -2)):
        assert trip(seconds)[0, 3] == pytest.approx(x, abs=1e-5)
    np.testing.assert_allclose(chain(trip, turn)(3.0), trip(3.0) @ turn(3.0), atol=1e-6)


def _seam_and_inner_steps(image: np.ndarray, axis: int) -> tuple[float, float]:
    """RMS difference of neighbours across the border, and of those inside."""
    steps = np.diff(image.astype(float), axis=axis, append=np.take(image, [0], axis).astype(float))
    across = np.take(steps, [-1], axis)
    return float(np.sqrt((across**2).mean())), float(np.sqrt((steps**2).mean()))


@pytest.mark.parametrize("axis", [0, 1])
def test_textures_repeat_without_a_seam(axis: int) -> None:
    for image in (fractal(256, 1, 1.2), fractal(256, 2, 0.8, (0.3, 3.0)), photo("gravel"), photo("grass")):
        seam, inner = _seam_and_inner_steps(image, axis)
        assert seam < 1.5 * inner


def test_masonry_repeats_and_counts_its_stones() -> None:
    inside, value, _ = masonry(256, 8, 4, 0.012, 3)
    assert len(np.unique(value)) == 8 * 4
    # The same wall drawn from any origin: a bed joint lies on the border of the texture, as on that of each row.
    joints = inside.mean(axis=1)
    assert joints[0] < 0.2
    assert joints[32] < 0.2
    assert joints[16] > 0.8


def test_normal_map_of_a_known_wave() -> None:
    size = 64
    height = np.broadcast_to(np.sin(2 * np.pi * np.arange(size) / size), (size, size))
    slope = 3.0 * np.sin(2 * np.pi / size) * np.cos(2 * np.pi * np.arange(size) / size)  # central difference
    expected = -slope / np.sqrt(slope**2 + 1)
    np.testing.assert_allclose(normals(height, 3.0)[10, :, 0] / 255 * 2 - 1, expected, atol=1 / 255 + 1e-9)
    # v runs down, green points up: a height that grows downwards leans up.
    ramp = normals(height.T.copy(), 3.0)
    assert ramp[0, 0, 1] > 128
    assert ramp[size // 2, 0, 1] < 128


def test_floor_tiles_are_seeded() -> None:
    colors = ([(0.1, 0.1, 0.1), (0.2, 0.2, 0.2)], [(0.8, 0.8, 0.8), (0.9, 0.9, 0.9)])
    first, second, third = (floor_tiles(64, 4, colors, seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, second)
    assert (first != third).mean() > 0.5
