"""How bright things are: shadows against geometry, reflectance and display against formulas, mip levels, the edges."""

from collections.abc import Callable

import numpy as np
import pytest
from analytic_scenes import (
    camera,
    eye,
    floor,
    glow,
    hit,
    pixel_points,
    quad,
    rays,
    scene,
    shift,
    still,
    turn,
    wall,
    whole,
)  # fmt: skip

from supersampling.render.camera import Camera
from supersampling.render.renderer import BUFFERS, Renderer
from supersampling.render.scene import Material, Mesh, PointLight, Scene, Sky, Sun

FRAME = whole(96, 96)
UP = np.array([0.0, 1.0, 0.0])
DOWN = turn(0.0, -np.pi / 2)
MATTE = Material("matte", roughness=1.0, double_sided=True)


def _bright(world: Scene, view: Camera, seconds: float = 0.0, shadow_size: int = 1024) -> np.ndarray:
    with Renderer(world, shadow_size) as draw:
        return draw.low(still(view, FRAME, seconds), 1, (0.0, 0.0), 0.0, frozenset({"color"}))["color"][
            ..., 1
        ]


def _floor_points(view: Camera) -> np.ndarray:
    """World points of the floor y = 0 under the pixels, NaN where none."""
    ray = rays(view, FRAME, pixel_points(FRAME, 1, (0.0, 0.0)))
    t = hit(eye(view), ray, np.zeros(3), UP)
    return np.where((t > 0)[..., None], eye(view) + t[..., None] * ray, np.nan)


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
    ground = _floor_points(view)
    for seconds in (0.0, 1.2) if moving else (0.0,):
        image = _bright(world, view, seconds, 4096)
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
    image = _bright(world, view)
    ground = _floor_points(view)
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
        ground = _floor_points(view)
        dark, lit = _inside(light + 0.5 * (ground - light) - centre, 0.5, 0.05)
        image = _bright(world, view, seconds)
        assert (dark & (np.abs(ground) < 4).all(axis=-1)).sum() > 100
        assert image[dark].max() < 0.02
        assert image[lit].min() > 0.3


def test_an_unshadowed_light_passes_through() -> None:
    light = PointLight((0.0, 3.0, 0.0), (30.0, 30.0, 30.0), 12.0, shadowed=False)
    world = scene([MATTE], [floor(8.0), floor(0.5)], [shift(0, 0, 0), shift(0, 1.5, 0)], points=[light])
    assert _bright(world, camera((0, 1.2, 0), DOWN, fov=1.5)).min() > 0.3


@pytest.mark.parametrize("sun", [True, False])
def test_alpha_tested_leaves_cast_a_holed_shadow(sun: bool) -> None:
    image = np.full((64, 64, 4), 255, np.uint8)
    image[16:48, 16:48, 3] = 0  # the middle half is open
    leaf = Material("leaf", albedo=image, alpha="test", double_sided=True)
    more: dict = (
        {"sun": Sun((0.0, 1.0, 0.0))} if sun else {"points": [PointLight((0, 4, 0), (40.0,) * 3, 12.0)]}
    )
    world = scene([MATTE, leaf], [floor(6.0), floor(1.0, 2.0, 1)], **more)
    view = camera((0, 1.8, 0), DOWN, fov=2.2)
    spread, ground = (1.0 if sun else 2.0), _floor_points(view)
    frame_dark, outside = _inside(ground, spread, 0.12)
    hole, frame = _inside(ground, spread / 2, 0.12)
    seen = _bright(world, view)
    assert hole.sum() > 60
    assert seen[hole].min() > 0.5
    assert seen[frame_dark & frame].max() < 0.02
    assert seen[outside].min() > 0.2


def _reflected(
    point: np.ndarray, unit: np.ndarray, view: Camera, normal: np.ndarray, paint: Material
) -> np.ndarray:
    """Lambert and GGX times the cosine, for light from ``unit``; Walter 2007, Heitz 2014, Schlick 1994, times pi."""
    out = eye(view) - point
    out /= np.linalg.norm(out, axis=-1, keepdims=True)
    middle = (unit + out) / np.linalg.norm(unit + out, axis=-1, keepdims=True)
    nl, nv, nh, vh = unit @ normal, out @ normal, middle @ normal, (out * middle).sum(axis=-1)
    a2, base = paint.roughness**4, paint.base_color[1]
    spread = a2 / (nh**2 * (a2 - 1) + 1) ** 2
    smith = 0.5 / (nl * np.sqrt(nv**2 * (1 - a2) + a2) + nv * np.sqrt(nl**2 * (1 - a2) + a2))
    f0 = 0.04 * (1 - paint.metallic) + base * paint.metallic
    fresnel = f0 + (1 - f0) * (1 - vh) ** 5
    return (base * (1 - paint.metallic) * (1 - fresnel) + spread * smith * fresnel) * nl


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("extent", [3.0, 90.0])  # the scene's size sets the texels: 6 mm, and 5 cm
@pytest.mark.parametrize("angle", [0.0, 0.7, 1.2, 1.45])
def test_a_sunlit_plane_is_as_bright_as_the_formula_and_has_no_acne(
    angle: float, extent: float, moving: bool
) -> None:
    direction = np.array([np.sin(angle) * 0.8, np.cos(angle), np.sin(angle) * 0.6])
    plain = Material("plain", base_color=(0.7,) * 3, roughness=0.9)
    still_floor = shift(0, 0, 0)
    # The sun's maps span what stands still.
    specks = [wall(x, x + 0.1, y, y + 0.1, x) for x, y in ((-extent, -2.0), (extent, -1.0))]
    transform = (lambda _: still_floor) if moving else still_floor
    world = scene([plain], [floor(3.0), *specks], [transform], Sun(tuple(direction), (3.0,) * 3))
    view = camera((0.3, 2.0, 1.0), turn(0.1, -1.3, 0.4))
    point = _floor_points(view)
    seen = (np.abs(point) < 2.9).all(axis=-1)
    truth = _display(3.0 * _reflected(point, direction, view, UP, plain))
    assert seen.mean() > 0.9
    np.testing.assert_allclose(_bright(world, view, 0.0, 2048)[seen], truth[seen], atol=3 / 255)


def test_a_room_lit_from_its_middle_has_no_acne_and_no_seams() -> None:
    walls = [
        quad(((-2, -2, -2), (2, -2, -2), (2, 2, -2), (-2, 2, -2))),
        quad(((2, -2, -2), (2, -2, 2), (2, 2, 2), (2, 2, -2))),
        quad(((-2, -2, 2), (-2, -2, -2), (-2, 2, -2), (-2, 2, 2))),
        floor(2.0, -2.0),
        quad(((-2, 2, -2), (2, 2, -2), (2, 2, 2), (-2, 2, 2))),
    ]
    view = camera((0.1, 0.0, 1.8), turn(0.2, 0.1), fov=1.6)
    place = (0.3, -0.2, 0.1)
    with_shadow, without = (
        _bright(scene([MATTE], walls, points=[PointLight(place, (4.0,) * 3, 8.0, shadowed)]), view)
        for shadowed in (True, False)
    )
    assert without.min() > 0.1
    np.testing.assert_allclose(with_shadow, without, atol=2 / 255)


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
    image = _bright(world, camera((4.0, 3.0, 0), turn(np.pi / 2, -0.7)))
    ground = _floor_points(camera((4.0, 3.0, 0), turn(np.pi / 2, -0.7)))
    # The box's wall at x = 1 is out of the sun; its shadow reaches x = 2.5. A texel is 16 mm.
    strip = (ground[..., 0] > 1.02) & (ground[..., 0] < 2.4) & (np.abs(ground[..., 2]) < 0.9)
    assert strip.sum() > 200
    assert image[strip].max() < 0.03
    lit = (ground[..., 0] > 2.6) & (ground[..., 0] < 4.0) & (np.abs(ground[..., 2]) < 0.9)
    assert image[lit].min() > 0.5
    within = _bright(world, camera((0, 0.7, 0), turn(0.3)))
    assert within.max() < 0.03


def _display(radiance: np.ndarray | np.float64) -> np.ndarray:
    """Narkowicz' ACES fit and IEC 61966-2-1."""
    x = np.clip((radiance * (2.51 * radiance + 0.03)) / (radiance * (2.43 * radiance + 0.59) + 0.14), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("level", [0.0, 0.002, 0.18, 1.0, 30.0])
def test_emission_is_displayed_by_the_formula(level: float) -> None:
    world = scene([glow(level)], [wall(-9, 9, -9, 9, -3)], exposure=1.5)
    np.testing.assert_allclose(_bright(world, camera()), _display(np.float64(1.5 * level)), atol=1e-3)


@pytest.mark.parametrize(("roughness", "metallic"), [(1.0, 0.0), (0.5, 0.0), (0.35, 1.0)])
def test_reflectance_and_falloff_are_those_of_the_formulas(roughness: float, metallic: float) -> None:
    base, light, radius, intensity = 0.6, np.array((0.8, 1.5, -0.5)), 5.0, 4.0
    paint = Material("paint", base_color=(base,) * 3, roughness=roughness, metallic=metallic)
    bulb = PointLight(tuple(light), (intensity,) * 3, radius, shadowed=False)
    view = camera((0, 2, 2), turn(0.0, -0.8))
    image = _bright(scene([paint], [floor(9.0)], points=[bulb]), view)
    point = _floor_points(view)
    to_light = light - point
    square = (to_light**2).sum(axis=-1)
    reflected = _reflected(point, to_light / np.sqrt(square)[..., None], view, UP, paint)
    fade = np.clip(1 - (square / radius**2) ** 2, 0, 1) ** 2
    truth = _display(reflected * intensity * fade / square)
    seen = square < 0.9 * radius**2
    assert np.ptp(truth[seen]) > 0.3
    np.testing.assert_allclose(image[seen], truth[seen], atol=3 / 255)


def _checker() -> Scene:
    """Texels of 1 mm, minified to 32 of them a low-resolution pixel at four metres."""
    tile = np.kron(np.indices((128, 128)).sum(axis=0) % 2, np.ones((2, 2)))
    noise = np.random.default_rng(3).integers(0, 2, (256, 256))
    image = np.repeat(((tile != noise) * 255).astype(np.uint8)[..., None], 3, axis=2)
    uv = ((0, 8), (8, 8), (8, 0), (0, 0))
    mesh = quad(((-2, -2, -4), (2, -2, -4), (2, 2, -4), (-2, 2, -4)), uv=uv)
    return scene([glow(0.5, albedo=image, base_color=(0.0, 0.0, 0.0))], [mesh])


def test_a_negative_mip_bias_sharpens_and_matches_the_full_resolution() -> None:
    shot = still(camera(fov=0.8), whole(512, 512))
    color = frozenset({"color"})
    with Renderer(_checker(), 64) as draw:
        spread = [
            float(draw.low(shot, 4, (0.0, 0.0), b, color)["color"].std()) for b in (0.0, -1.0, -2.0, -3.0)
        ]
        full = float(draw.low(shot, 1, (0.0, 0.0), 0.0, color)["color"].std())
        target = float(draw.target(shot, 1, 0.0).std())
        # A target's levels are those of its own pixels, however many samples it takes.
        fine = draw.target(shot, 2, 0.0)
        mean = np.mean(
            [draw.low(shot, 1, (x, y), 0.0, color)["color"] for x in (-0.25, 0.25) for y in (-0.25, 0.25)],
            axis=0,
        )
    assert spread[1] > 1.3 * spread[0]
    assert spread[2] > 1.3 * spread[1]
    assert spread[3] > 1.1 * spread[2]
    assert spread[2] == pytest.approx(full, rel=0.05)
    assert target == pytest.approx(full, rel=1e-3)
    assert np.abs(fine - mean).mean() < 2e-3


def _finite(world: Scene, view: Camera) -> None:
    with Renderer(world, 128) as draw:
        out = draw.low(still(view, FRAME), 2, (0.1, -0.2), -2.0, BUFFERS)
        target = draw.target(still(view, FRAME), 2, 0.0)
    for name, image in (*out.items(), ("target", target)):
        assert np.isfinite(image).all(), name
    assert out["color"].min() >= 0.0
    assert max(out["color"].max(), target.max()) <= 1.0


def _mirror(_: np.ndarray) -> tuple[list[Material], list[Mesh]]:
    return [Material("mirror", roughness=0.0, metallic=1.0)], [floor(40.0)]


def _zero_normals(_: np.ndarray) -> tuple[list[Material], list[Mesh]]:
    mesh = wall(-2, 2, -1, 3, -4)
    return [Material("bad")], [Mesh(mesh.positions, 0 * mesh.normals, mesh.uv, mesh.triangles, 0)]


def _no_uv(bumps: np.ndarray) -> tuple[list[Material], list[Mesh]]:
    mesh = wall(-2, 2, -1, 3, -4)
    material = Material("bumps", albedo=bumps, normal=bumps, surface=bumps)
    return [material], [Mesh(mesh.positions, mesh.normals, 0 * mesh.uv, mesh.triangles, 0)]


def _slivers(bumps: np.ndarray) -> tuple[list[Material], list[Mesh]]:
    p = np.array([(-2, 0, -4), (2, 0, -4), (2, 0, -4), (0, 1, -4), (0, 1, -4), (0, 1, -4)], np.float32)
    triangles = np.array([[0, 1, 2], [3, 4, 5], [0, 1, 3]], np.uint32)
    mesh = Mesh(p, np.tile(np.array((0, 0, 1), np.float32), (6, 1)), p[:, :2].copy(), triangles, 0)
    return [Material("bumps", normal=bumps)], [mesh, floor(9.0)]


def _flat_normal_map(_: np.ndarray) -> tuple[list[Material], list[Mesh]]:
    return [Material("grey", normal=np.full((4, 4, 3), 128, np.uint8))], [floor(9.0)]


@pytest.mark.parametrize("build", [_mirror, _zero_normals, _no_uv, _slivers, _flat_normal_map])
def test_nothing_is_infinite_or_undefined(build: Callable) -> None:
    bumps = np.random.default_rng(0).integers(0, 256, (16, 16, 4)).astype(np.uint8)
    materials, meshes = build(bumps)
    lights = [
        PointLight((0.0, 0.0, -4.0), (50.0,) * 3, 6.0),  # on the surfaces
        PointLight((0.3, 1e-4, -3.0), (5000.0,) * 3, 6.0, shadowed=False),
    ]
    world = scene(materials, meshes, sun=Sun((0.0, 0.02, 1.0), (900.0,) * 3), sky=Sky(), points=lights)
    _finite(world, camera((0, 0.02, 0)))  # grazes the floor
    _finite(world, camera((0, 2.0, 0.0), DOWN))


def test_an_empty_scene_is_all_sky() -> None:
    world = scene([], [], sun=Sun(), sky=Sky((0.2,) * 3, (0.2,) * 3, (0.2,) * 3))
    np.testing.assert_allclose(_bright(world, camera()), _display(np.float64(0.2)), atol=1e-3)
