"""Where shadows lie: against geometry."""

import numpy as np
import pytest
from analytic_scenes import DOWN, MATTE, bright, camera, eye, floor, floor_points, quad, scene, shift, turn

from supersampling.scenes.scene import Material, Mesh, PointLight, Sun


def _inside(points: np.ndarray, half: float, margin: float) -> tuple[np.ndarray, np.ndarray]:
    """Surely in and surely out of the square |x|, |z| < half."""
    reach = np.abs(points[..., [0, 2]]).max(axis=-1)
    return reach < half - margin, reach > half + margin


@pytest.mark.parametrize("extent", [12.0, 90.0])  # one map over the whole scene; near and far maps
@pytest.mark.parametrize("moving", [False, True])
def test_the_sun_shadow_lies_where_geometry_says(extent: float, moving: bool) -> None:
    direction = np.array((0.5, 0.7, 0.2))

    def place(seconds: float) -> np.ndarray:
        return shift(1.5 * seconds, 2.0, -seconds)

    transforms = [shift(0, 0, 0), place if moving else place(0.0)]
    world = scene([MATTE], [floor(extent), floor(1.0)], transforms, Sun(tuple(direction), (2.0, 2.0, 2.0)))
    view = camera((-3.5, 7.0, 2.5), turn(-0.55, -1.05))
    ground = floor_points(view)
    for seconds in (0.0, 1.2) if moving else (0.0,):
        image = bright(world, view, seconds, 4096)
        centre = place(seconds)[:3, 3].astype(np.float64)
        dark, lit = _inside(ground + 2.0 / direction[1] * direction - centre, 1.0, 0.25)
        # The blocker itself covers some of the floor.
        ray = ground - eye(view)
        over = eye(view) + (2.0 - eye(view)[1]) / ray[..., 1:2] * ray - centre
        free = _inside(over, 1.0, 0.1)[1] & (np.abs(ground) < 10.0).all(axis=-1)
        assert (dark & free).sum() > 40
        assert image[dark & free].max() < 0.02
        assert image[lit & free].min() > 0.5


def test_the_far_sun_map_has_the_shadow_too() -> None:
    direction = np.array((0.4, 0.8, 0.0))
    world = scene(
        [MATTE], [floor(90.0), floor(6.0)], [shift(0, 0, 0), shift(0, 4, 0)], Sun(tuple(direction)), far=200.0
    )
    view = camera((0, 75, 0), DOWN, fov=0.5)  # beyond the near map's reach
    image = bright(world, view)
    ground = floor_points(view)
    dark, _ = _inside(ground + 4.0 / direction[1] * direction, 6.0, 1.0)
    ray = ground - eye(view)
    over = eye(view) + (4.0 - 75.0) / ray[..., 1:2] * ray
    free = _inside(over, 6.0, 0.5)[1]
    assert (dark & free).sum() > 20
    assert image[dark & free].max() < 0.02
    _, lit = _inside(ground + 4.0 / direction[1] * direction, 6.0, 1.0)
    assert image[lit & free].min() > 0.5


@pytest.mark.parametrize("moving", [False, True])
def test_a_point_light_casts_a_shadow(moving: bool) -> None:
    light = np.array((0.4, 3.0, -0.3))

    def place(seconds: float) -> np.ndarray:
        return shift(0.8 * seconds, 1.5, 0.5 * seconds)

    world = scene(
        [MATTE], [floor(8.0), floor(0.5)], [shift(0, 0, 0), place if moving else place(0.0)],
        points=[PointLight(tuple(light), (30.0, 30.0, 30.0), 12.0)],
    )  # fmt: skip
    view = camera((0, 1.2, 0), DOWN, fov=2.0)  # under the blocker
    for seconds in (0.0, 1.0) if moving else (0.0,):
        centre = place(seconds)[:3, 3].astype(np.float64)
        ground = floor_points(view)
        dark, lit = _inside(light + 0.5 * (ground - light) - centre, 0.5, 0.05)
        image = bright(world, view, seconds)
        assert (dark & (np.abs(ground) < 4).all(axis=-1)).sum() > 100
        assert image[dark].max() < 0.02
        assert image[lit].min() > 0.3


def test_an_unshadowed_light_passes_through() -> None:
    light = PointLight((0.0, 3.0, 0.0), (30.0, 30.0, 30.0), 12.0, shadowed=False)
    world = scene([MATTE], [floor(8.0), floor(0.5)], [shift(0, 0, 0), shift(0, 1.5, 0)], points=[light])
    assert bright(world, camera((0, 1.2, 0), DOWN, fov=1.5)).min() > 0.3


@pytest.mark.parametrize("sun", [True, False])
def test_alpha_tested_leaves_cast_a_holed_shadow(sun: bool) -> None:
    image = np.full((64, 64, 4), 255, np.uint8)
    image[16:48, 16:48, 3] = 0  # the middle half is open
    leaf = Material("leaf", albedo=image, alpha="test", double_sided=True)
    more: dict = {"sun": Sun((0.0, 1.0, 0.0))} if sun else {"points": [PointLight((0, 4, 0), (40.0,) * 3, 12.0)]}
    world = scene([MATTE, leaf], [floor(6.0), floor(1.0, 2.0, 1)], **more)
    view = camera((0, 1.8, 0), DOWN, fov=2.2)
    spread, ground = (1.0 if sun else 2.0), floor_points(view)
    frame_dark, outside = _inside(ground, spread, 0.12)
    hole, frame = _inside(ground, spread / 2, 0.12)
    seen = bright(world, view)
    assert hole.sum() > 60
    assert seen[hole].min() > 0.5
    assert seen[frame_dark & frame].max() < 0.02
    assert seen[outside].min() > 0.2


def _box(half: float, height: float) -> list[Mesh]:
    h, t = half, height
    return [
        quad(((-h, 0, h), (h, 0, h), (h, t, h), (-h, t, h))),
        quad(((h, 0, h), (h, 0, -h), (h, t, -h), (h, t, h))),
        quad(((h, 0, -h), (-h, 0, -h), (-h, t, -h), (h, t, -h))),
        quad(((-h, 0, -h), (-h, 0, h), (-h, t, h), (-h, t, -h))),
        floor(half, height),
    ]


def test_shadows_start_at_the_foot_of_a_box_and_none_leaks_inside() -> None:
    world = scene([MATTE], [floor(8.0), *_box(1.0, 1.5)], sun=Sun((-1.0, 1.0, 0.0)))
    image = bright(world, camera((4.0, 3.0, 0), turn(np.pi / 2, -0.7)))
    ground = floor_points(camera((4.0, 3.0, 0), turn(np.pi / 2, -0.7)))
    # The box's wall at x = 1 is out of the sun; its shadow reaches x = 2.5. A texel is 16 mm.
    strip = (ground[..., 0] > 1.02) & (ground[..., 0] < 2.4) & (np.abs(ground[..., 2]) < 0.9)
    assert strip.sum() > 200
    assert image[strip].max() < 0.03
    lit = (ground[..., 0] > 2.6) & (ground[..., 0] < 4.0) & (np.abs(ground[..., 2]) < 0.9)
    assert image[lit].min() > 0.5
    within = bright(world, camera((0, 0.7, 0), turn(0.3)))
    assert within.max() < 0.03
