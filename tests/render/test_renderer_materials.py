"""What a surface looks like: mip levels, maps, factors and lights against the formulas in float64."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_scenes import (
    camera,
    eye,
    floor,
    glow,
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

from supersampling.render.camera import Camera, Window
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Material, Mesh, PointLight, Scene, Sun

COLOR = frozenset({"color"})
SQUARE = camera(fov=2 * np.arctan(0.25))  # a wall of side 2 at distance 4 fills a square frame
DOWN = turn(0.0, -np.pi / 2)


def _linear(srgb: np.ndarray) -> np.ndarray:
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _displayed(radiance: np.ndarray) -> np.ndarray:
    """ACES after Narkowicz, then the sRGB curve."""
    x = np.clip(radiance * (2.51 * radiance + 0.03) / (radiance * (2.43 * radiance + 0.59) + 0.14), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


@pytest.fixture(scope="module")
def noise() -> np.ndarray:
    """256 x 256 texels of which no two neighbours agree, so that every mip level looks different."""
    grey = np.random.default_rng(1).integers(0, 256, (256, 256, 1), dtype=np.uint8)
    return np.repeat(grey, 3, axis=2)


def _level(texture: np.ndarray, level: int) -> np.ndarray:
    """Mean radiance of blocks of ``2^level`` texels."""
    linear = _linear(texture[..., 0].astype(np.float64) / 255)
    side = len(linear) >> level
    return linear.reshape(side, len(linear) // side, side, -1).mean(axis=(1, 3))


def _painted(texture: np.ndarray) -> Scene:
    return scene([glow(0.5, albedo=texture)], [wall(-1, 1, -1, 1, -4)])


@pytest.mark.parametrize(
    ("scale", "bias", "level"), [(1, 0.0, 2), (1, -1.0, 1), (1, 1.0, 3), (4, 0.0, 4), (4, -2.0, 2)]
)
def test_mip_bias_counts_levels_of_the_rendered_resolution(
    noise: np.ndarray, scale: int, bias: float, level: int
) -> None:
    # 256 texels over 64 target pixels: level 2 at full resolution, 4 at a quarter; -log2(scale) brings back level 2.
    per_pixel = 4 * scale
    texel = 2**level
    # Half a texel off the pixel's middle hits a texel's centre, where nothing is interpolated.
    offset = texel / 2 if texel < per_pixel else 0.0
    jitter = (offset / per_pixel, -offset / per_pixel)
    with Renderer(_painted(noise), 64) as draw:
        image = draw.low(still(SQUARE, whole(64, 64)), scale, jitter, bias, COLOR)["color"][..., 0]
    at = (np.arange(64 // scale) + 0.5) * per_pixel
    if texel <= per_pixel:
        rows, columns = ((at - offset) // texel).astype(int), ((at + offset) // texel).astype(int)
        expected = _displayed(0.5 * _level(noise, level)[np.ix_(rows, columns)])
    else:
        expected = _displayed(0.5 * _bilinear(_level(noise, level), at / texel))
    assert expected.std() > 0.015
    np.testing.assert_allclose(image, expected, atol=0.02)


def _bilinear(texture: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Repeating texture at the grid of positions ``at`` (texels) in both axes."""
    low = np.floor(at - 0.5).astype(int)
    part = at - 0.5 - low
    weights = np.zeros((len(at), len(texture)))
    rows = np.arange(len(at))
    np.add.at(weights, (rows, low % len(texture)), 1 - part)
    np.add.at(weights, (rows, (low + 1) % len(texture)), part)
    return weights @ texture @ weights.T


@pytest.mark.parametrize("samples", [2, 4])
def test_the_target_keeps_its_mip_level_at_any_sample_count(noise: np.ndarray, samples: int) -> None:
    with Renderer(_painted(noise), 64) as draw:
        image = draw.target(still(SQUARE, whole(16, 16)), samples, 0.0)[..., 0]
    at = (np.arange(16 * samples) + 0.5) / samples
    ones = _displayed(0.5 * _bilinear(_level(noise, 4), at))
    expected = ones.reshape(16, samples, 16, samples).mean(axis=(1, 3))
    np.testing.assert_allclose(image, expected, atol=0.01)


def _reflected(
    albedo: np.ndarray, roughness: float, metallic: float, normal: np.ndarray, view: np.ndarray, light: np.ndarray
) -> np.ndarray:
    """pi times the reflectance times the cosine: NSRD's supplement, equations 1 to 10."""
    half = (view + light) / np.linalg.norm(view + light, axis=-1, keepdims=True)

    def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a * b).sum(axis=-1, keepdims=True)

    nl, nv, nh, vh = dot(normal, light), dot(normal, view), dot(normal, half), dot(view, half)
    a2 = roughness**4
    f0 = 0.04 * (1 - metallic) + albedo * metallic
    fresnel = f0 + (1 - f0) * (1 - vh) ** 5
    distribution = a2 / (np.pi * (nh**2 * (a2 - 1) + 1) ** 2)
    k = (roughness**2 + 1) ** 2 / 8
    masked = [c / (c * (1 - k) + k) for c in (nl, nv)]
    specular = distribution * masked[0] * masked[1] * fresnel / (4 * nl * nv)
    diffuse = albedo * (1 - metallic) / np.pi
    return np.where(nl > 0, np.pi * (diffuse + specular) * nl, 0.0)


def _flat(*values: int) -> np.ndarray:
    return np.full((4, 4, len(values)), values, np.uint8)


@pytest.mark.parametrize(("roughness", "metallic"), [(1.0, 0.0), (0.4, 0.0), (0.5, 1.0), (0.7, 0.5)])
def test_reflectance_under_the_sun(roughness: float, metallic: float) -> None:
    sun = np.array([0.4, 0.3, 0.8])
    sun /= np.linalg.norm(sun)
    # Half of each factor comes from the surface map: 128 / 255.
    material = Material(
        "paint", albedo=_flat(200, 120, 60), surface=_flat(128, 128, 255), base_color=(0.9, 0.8, 1.0),
        roughness=roughness * 255 / 128, metallic=metallic * 255 / 128,
    )  # fmt: skip
    world = scene([material], [wall(-4, 4, -4, 4, -4)], sun=Sun(tuple(2 * sun), (0.9, 1.1, 1.3)), exposure=0.6)
    tinted = [replace(world.meshes[0], colors=np.full((4, 3), (1.0, 0.6, 0.2), np.float32))]
    view, window = camera((0.1, 0.2, 0)), whole(24, 16)
    with Renderer(replace(world, meshes=tinted), 64) as draw:
        image = draw.low(still(view, window), 1, (0.2, -0.3), 0.0, COLOR)["color"]
    ray = rays(view, window, pixel_points(window, 1, (0.2, -0.3)))
    toward = -ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    albedo = _linear(np.array([200, 120, 60]) / 255) * (0.9, 0.8, 1.0) * (1.0, 0.6, 0.2)
    light = _reflected(albedo, roughness, metallic, np.array([0.0, 0, 1]), toward, sun) * (0.9, 1.1, 1.3)
    np.testing.assert_allclose(image, _displayed(0.6 * light), atol=4e-3)


@pytest.mark.parametrize("tilt", [(0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.3, -0.4)])
@pytest.mark.parametrize("mirrored", [False, True])
def test_normal_maps_lean_right_with_red_and_up_with_green(tilt: tuple[float, float], mirrored: bool) -> None:
    normal = np.array([*tilt, np.sqrt(1 - tilt[0] ** 2 - tilt[1] ** 2)])
    texel = np.rint((normal * 0.5 + 0.5) * 255).astype(int)
    placed = shift(0, 0, -4)
    if mirrored:
        placed[0, 0] = -1.0
        normal[0] *= -1.0
    world = scene([Material("m", normal=_flat(*texel))], [wall(-4, 4, -4, 4, 0)], [placed], sun=Sun((0.3, 0.5, 0.8)))
    window = whole(16, 16)
    with Renderer(world, 64) as draw:
        image = draw.low(still(SQUARE, window), 1, (0, 0), 0.0, COLOR)["color"]
    ray = rays(SQUARE, window, pixel_points(window, 1, (0, 0)))
    sun = np.array([0.3, 0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
    toward = -ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    light = _reflected(np.ones(3), 0.8, 0.0, normal, toward, sun) * (3.0, 2.8, 2.5)
    np.testing.assert_allclose(image, _displayed(light), atol=0.01)


def _ground(view: Camera, window: Window) -> np.ndarray:
    """Points of the floor y = 0 at pixel centres."""
    ray = rays(view, window, pixel_points(window, 1, (0, 0)))
    return eye(view) - eye(view)[1] / ray[..., 1:2] * ray


def test_a_point_light_falls_off_to_nothing_at_its_radius() -> None:
    view, window = camera((0, 6, 0), DOWN), whole(48, 48)
    light = PointLight((0.5, 1.5, -0.3), (4.0, 2.0, 1.0), 2.5, shadowed=False)
    with Renderer(scene([Material("floor")], [floor(5.0)], points=[light]), 64) as draw:
        image = draw.low(still(view, window), 1, (0, 0), 0.0, COLOR)["color"]
    place = _ground(view, window)
    toward = np.array(light.position) - place
    distance = np.linalg.norm(toward, axis=-1, keepdims=True)
    out = (eye(view) - place) / np.linalg.norm(eye(view) - place, axis=-1, keepdims=True)
    fade = np.clip(1 - (distance / 2.5) ** 4, 0, 1) ** 2 / distance**2
    truth = _reflected(np.ones(3), 0.8, 0.0, np.array([0.0, 1, 0]), out, toward / distance) * light.intensity * fade
    np.testing.assert_allclose(image, _displayed(truth), atol=5e-3)
    assert (image[distance[..., 0] > 2.5] == 0.0).all()


def _lid(half_x: float, half_z: float, material: int = 1) -> Mesh:
    """A horizontal sheet at y = 1, facing up, its texture once over it."""
    x, z = half_x, half_z
    return quad(((-x, 1, z), (x, 1, z), (x, 1, -z), (-x, 1, -z)), material)


def test_a_moving_shadow_leaves_nothing_behind() -> None:
    view, window = camera((0, 12, 0), DOWN, fov=0.6), whole(64, 64)
    points = [PointLight((0, 3, 0), (40, 40, 40), 12.0)]
    meshes = [_lid(0.5, 0.5), floor(4.0)]
    world = scene(
        [Material("floor"), Material("lid")], meshes, [lambda t: shift(2.0 * t, 0, 0)], sun=Sun(), points=points
    )
    with Renderer(world, 256) as draw:
        before = draw.low(still(view, window, 0.0), 1, (0, 0), 0.0, COLOR)["color"]
        after = draw.low(still(view, window, 1.0), 1, (0, 0), 0.0, COLOR)["color"]
    with Renderer(world, 256) as draw:
        fresh = draw.low(still(view, window, 1.0), 1, (0, 0), 0.0, COLOR)["color"]
    assert np.abs(before - after).max() > 0.2
    np.testing.assert_array_equal(after, fresh)
