"""How bright things are: reflectance and display against formulas, mip levels, the edges."""

from collections.abc import Callable

import numpy as np
import pytest
from analytic_scenes import (
    DOWN,
    FRAME,
    MATTE,
    UP,
    bright,
    camera,
    eye,
    floor,
    floor_points,
    glow,
    quad,
    scene,
    shift,
    still,
    turn,
    wall,
    whole,
)

from supersampling.render.camera import Camera
from supersampling.render.jitter import target_mip_bias
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Material, Mesh, PointLight, Scene, Sky, Sun


def _reflected(point: np.ndarray, unit: np.ndarray, view: Camera, normal: np.ndarray, paint: Material) -> np.ndarray:
    """Times pi and the cosine: NSRD's reflectance (supplement, equations 1 to 10) for light from ``unit``."""
    out = eye(view) - point
    out /= np.linalg.norm(out, axis=-1, keepdims=True)
    middle = (unit + out) / np.linalg.norm(unit + out, axis=-1, keepdims=True)
    nl, nv, nh, vh = unit @ normal, out @ normal, middle @ normal, (out * middle).sum(axis=-1)
    a2, base = paint.roughness**4, paint.base_color[1]
    spread = a2 / (nh**2 * (a2 - 1) + 1) ** 2
    k = (paint.roughness**2 + 1) ** 2 / 8
    masked = [cosine / (cosine * (1 - k) + k) for cosine in (nl, nv)]
    f0 = 0.04 * (1 - paint.metallic) + base * paint.metallic
    fresnel = f0 + (1 - f0) * (1 - vh) ** 5
    specular = spread * fresnel * masked[0] * masked[1] / (4 * nl * nv)
    return (base * (1 - paint.metallic) + specular) * nl


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("extent", [3.0, 90.0])  # the scene's size sets the texels: 6 mm, and 5 cm
@pytest.mark.parametrize("angle", [0.0, 0.7, 1.2, 1.45])
def test_a_sunlit_plane_is_as_bright_as_the_formula_and_has_no_acne(angle: float, extent: float, moving: bool) -> None:
    direction = np.array([np.sin(angle) * 0.8, np.cos(angle), np.sin(angle) * 0.6])
    plain = Material("plain", base_color=(0.7,) * 3, roughness=0.9)
    still_floor = shift(0, 0, 0)
    # The sun's maps span what stands still.
    specks = [wall(x, x + 0.1, y, y + 0.1, x) for x, y in ((-extent, -2.0), (extent, -1.0))]
    transform = (lambda _: still_floor) if moving else still_floor
    world = scene([plain], [floor(3.0), *specks], [transform], Sun(tuple(direction), (3.0,) * 3))
    view = camera((0.3, 2.0, 1.0), turn(0.1, -1.3, 0.4))
    point = floor_points(view)
    seen = (np.abs(point) < 2.9).all(axis=-1)
    truth = _display(3.0 * _reflected(point, direction, view, UP, plain))
    assert seen.mean() > 0.9
    np.testing.assert_allclose(bright(world, view, 0.0, 2048)[seen], truth[seen], atol=3 / 255)


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
        bright(scene([MATTE], walls, points=[PointLight(place, (4.0,) * 3, 8.0, shadowed)]), view)
        for shadowed in (True, False)
    )
    assert without.min() > 0.1
    np.testing.assert_allclose(with_shadow, without, atol=2 / 255)


def _display(radiance: np.ndarray | np.float64) -> np.ndarray:
    """Narkowicz' ACES fit and IEC 61966-2-1."""
    x = np.clip((radiance * (2.51 * radiance + 0.03)) / (radiance * (2.43 * radiance + 0.59) + 0.14), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("level", [0.0, 0.002, 0.18, 1.0, 30.0])
def test_emission_is_displayed_by_the_formula(level: float) -> None:
    world = scene([glow(level)], [wall(-9, 9, -9, 9, -3)], exposure=1.5)
    np.testing.assert_allclose(bright(world, camera()), _display(np.float64(1.5 * level)), atol=1e-3)


@pytest.mark.parametrize(("roughness", "metallic"), [(1.0, 0.0), (0.5, 0.0), (0.35, 1.0)])
def test_reflectance_and_falloff_are_those_of_the_formulas(roughness: float, metallic: float) -> None:
    base, light, radius, intensity = 0.6, np.array((0.8, 1.5, -0.5)), 5.0, 4.0
    paint = Material("paint", base_color=(base,) * 3, roughness=roughness, metallic=metallic)
    bulb = PointLight(tuple(light), (intensity,) * 3, radius, shadowed=False)
    view = camera((0, 2, 2), turn(0.0, -0.8))
    image = bright(scene([paint], [floor(9.0)], points=[bulb]), view)
    point = floor_points(view)
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
        spread = [float(draw.low(shot, 4, (0.0, 0.0), b, color)["color"].std()) for b in (0.0, -1.0, -2.0, -3.0)]
        full = float(draw.low(shot, 1, (0.0, 0.0), 0.0, color)["color"].std())
        target = float(draw.target(shot, 1, 0.0).std())
        # A target's levels are those of its own pixels, however many samples it takes.
        fine = draw.target(shot, 2, 0.0)
        mean = np.mean(
            [draw.low(shot, 1, (x, y), 0.0, color)["color"] for x in (-0.25, 0.25) for y in (-0.25, 0.25)], axis=0
        )
    assert spread[1] > 1.3 * spread[0]
    assert spread[2] > 1.3 * spread[1]
    assert spread[3] > 1.1 * spread[2]
    assert spread[2] == pytest.approx(full, rel=0.05)
    assert target == pytest.approx(full, rel=1e-3)
    assert np.abs(fine - mean).mean() < 2e-3


def test_a_supersampled_target_is_the_box_filtered_image_of_the_finer_resolution() -> None:
    """NSRD 4.1: rendered at twice the resolution without a bias, then a 2x2 box filter."""
    view = camera(fov=0.8)
    with Renderer(_checker(), 64) as draw:
        fine = draw.low(still(view, whole(512, 512)), 1, (0.0, 0.0), 0.0, frozenset({"color"}))["color"]
        expected = fine.reshape(256, 2, 256, 2, 3).mean(axis=(1, 3))
        finer, own = (
            draw.target(still(view, whole(256, 256)), 2, target_mip_bias(setting))
            for setting in ("supersampled2", "matched")
        )
    assert np.abs(finer - expected).mean() < 2e-3
    assert np.abs(own - expected).mean() > 1e-2


def _finite(world: Scene, view: Camera) -> None:
    with Renderer(world, 128) as draw:
        out = draw.low(still(view, FRAME), 2, (0.1, -0.2), -2.0, frozenset({"color", "depth", "motion"}))
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
    np.testing.assert_allclose(bright(world, camera()), _display(np.float64(0.2)), atol=1e-3)
