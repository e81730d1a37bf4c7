"""The material buffers, their demodulation, the interface and the furnace, against what the scene says."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from analytic_scenes import DARK, FRAME, camera, floor, glow, scene, shift, still, turn, wall, whole

from supersampling.frames import BUFFERS
from supersampling.ops.demodulate import demodulate, remodulate
from supersampling.render.camera import Shot
from supersampling.render.renderer import Renderer
from supersampling.scenes.scene import Material, Object, PointLight, Scene, Sky

LOW = frozenset(n for n, b in BUFFERS.items() if b.resolution == "low")
HIGH = frozenset(n for n, b in BUFFERS.items() if b.resolution == "high")
_TEXELS = {"albedo": (200, 90, 30), "glow": (40, 120, 250), "surface": (128, 64, 51)}
WHITE = Sky((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 1.0, 1.0), 1.0)


def reflectance_in_all(n_dot_v: float, roughness: float, base: float, metallic: float) -> float:
    """Integrate NSRD's reflectance over the hemisphere in float64, at midpoints of GGX quantiles and azimuths."""
    alpha = roughness**2
    k, f0 = (alpha + 1) ** 2 / 8, 0.04 * (1 - metallic) + base * metallic
    u, phi = np.meshgrid((np.arange(2000) + 0.5) / 2000, (np.arange(720) + 0.5) / 720 * 2 * np.pi)
    cos_h = np.sqrt((1 - u) / (1 + (alpha**2 - 1) * u))
    sin_h = np.sqrt(1 - cos_h**2)
    v = np.array([np.sqrt(1 - n_dot_v**2), 0.0, n_dot_v])
    vh = sin_h * np.cos(phi) * v[0] + cos_h * v[2]
    nl = 2 * vh * cos_h - n_dot_v
    good = (nl > 0) & (vh > 0)
    masked = [c / (c * (1 - k) + k) for c in (np.where(good, nl, 1.0), n_dot_v)]
    fresnel = f0 + (1 - f0) * (1 - vh.clip(0, 1)) ** 5
    # The density of l is D (n.h) / (4 (v.h)): what is left of rho (n.l) is F G (v.h) / ((n.h) (n.v)).
    specular = np.where(good, fresnel * masked[0] * masked[1] * vh / (cos_h * n_dot_v), 0.0).mean()
    return base * (1 - metallic) + float(specular)


@pytest.mark.parametrize("metallic", [0.0, 1.0])
@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_a_white_furnace_reflects_the_integral_of_the_reflectance(roughness, metallic):
    """Under white light from everywhere a white surface has the radiance F_beta, and its lighting is 1."""
    paint = Material("white", roughness=roughness, metallic=metallic)
    view = camera((0, 1.0, 0), turn(0.0, -0.75))
    with Renderer(scene([paint], [floor(40.0)], sky=WHITE), 64) as draw:
        out = draw.low(still(view, FRAME), 1, (0.0, 0.0), 0.0, LOW)
    seen = (out["depth"][..., 0] < 1.0) & (out["n_dot_v"][..., 0] > 0.1)
    assert seen.mean() > 0.5
    for n_dot_v in (0.15, 0.4, 0.65, 0.95):
        chosen = seen & (np.abs(out["n_dot_v"][..., 0] - n_dot_v) < 0.01)
        if chosen.any():
            truth = reflectance_in_all(float(out["n_dot_v"][chosen].mean()), roughness, 1.0, metallic)
            np.testing.assert_allclose(out["radiance"][chosen].mean(), truth, rtol=0.01)
            np.testing.assert_allclose(out["material"][chosen].mean(), truth, rtol=0.01)
    lighting = demodulate(*(_tensor(out[n]) for n in ("radiance", "material", "emission")))
    np.testing.assert_allclose(lighting[0].permute(1, 2, 0).numpy()[seen], 1.0, rtol=0.01)


def _tensor(image: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(np.array(image)).permute(2, 0, 1)[None]


@pytest.fixture(scope="module")
def painted() -> Scene:
    """A lit painted wall, a glowing one beside it, sky above."""
    paint = Material("paint", base_color=(0.6, 0.3, 0.1), roughness=0.5, metallic=0.25, double_sided=True)
    lamp = PointLight((0.0, 0.5, -2.0), (3.0, 3.0, 3.0), 9.0, shadowed=False)
    meshes = [wall(-3, 0, -3, 1, -4, 0), wall(0, 3, -3, 1, -4, 1)]
    sky = Sky((0.2, 0.4, 0.8), (0.2, 0.4, 0.8), (0.2, 0.4, 0.8), 0.3)
    return scene([paint, glow(0.5)], meshes, points=[lamp], sky=sky, exposure=2.0)


def test_buffers_hold_what_the_materials_say(painted):
    view = camera((0, 0, 0), turn(0.1, -0.05))
    with Renderer(painted, 64) as draw:
        out = draw.low(still(view, FRAME), 2, (0.1, -0.2), 0.0, LOW)
    ids = out["object_id"][..., 0]
    paint, lamp, sky = ids == 1, ids == 2, ids == 0
    assert min(paint.mean(), lamp.mean(), sky.mean()) > 0.1
    base = np.array((0.6, 0.3, 0.1))
    np.testing.assert_allclose(out["albedo"][paint], np.tile(base, (paint.sum(), 1)), atol=1e-3)
    np.testing.assert_allclose(out["metallic"][paint], 0.25, atol=1e-3)
    np.testing.assert_allclose(out["roughness"][paint], 0.5, atol=1e-3)
    np.testing.assert_allclose(out["specular"][paint], np.tile(0.03 + 0.25 * base, (paint.sum(), 1)), atol=1e-3)
    # The wall faces +z; in the camera's axes (x right, y down, z towards it).
    normal = np.diag([1.0, -1.0, 1.0]) @ view.view[:3, :3] @ np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(out["normal"][paint], np.tile(normal, (paint.sum(), 1)), atol=2e-3)
    np.testing.assert_allclose(out["emission"][lamp], 1.0, atol=1e-3)  # 0.5 at exposure 2
    np.testing.assert_allclose(out["emission"][sky], np.tile((0.4, 0.8, 1.6), (sky.sum(), 1)), atol=1e-3)
    assert (out["emission"][paint] == 0).all()
    for name in ("albedo", "metallic", "roughness", "specular", "n_dot_v", "material", "normal"):
        assert (out[name][sky] == 0).all(), name
    np.testing.assert_allclose(out["radiance"][sky], out["emission"][sky], rtol=1e-6)


def test_a_glow_map_stands_beside_the_albedo():
    """The left wall emits its glow map alone, the right one, without it, its albedo under the surface map's mask."""
    texels = {name: np.full((2, 2, 3), value, np.uint8) for name, value in _TEXELS.items()}
    mask = Material("mask", texels["albedo"], None, texels["surface"])
    mask = replace(mask, base_color=(0.5, 0.5, 0.5), emission=(4.0, 2.0, 1.0))
    lamps = replace(mask, name="lamps", glow=texels["glow"])
    world = scene([lamps, mask], [wall(-4, 0, -4, 4, -3, 0), wall(0, 4, -4, 4, -3, 1)])
    names = frozenset({"emission", "albedo", "radiance", "object_id"})
    with Renderer(replace(world, exposure=2.0), 64) as draw:
        out = draw.low(still(camera(), FRAME), 1, (0.0, 0.0), 0.0, names)
    linear = {name: ((np.array(v) / 255 + 0.055) / 1.055) ** 2.4 for name, v in _TEXELS.items()}
    wanted = (linear["glow"], linear["albedo"] * _TEXELS["surface"][2] / 255)
    for number, factor in enumerate(wanted, start=1):
        seen = out["object_id"][..., 0] == number
        assert seen.mean() > 0.4
        emitted = np.tile(2.0 * np.array((4.0, 2.0, 1.0)) * factor, (seen.sum(), 1))
        # The software renderer decodes sRGB by a polynomial.
        np.testing.assert_allclose(out["emission"][seen], emitted, rtol=0.02)
        np.testing.assert_allclose(out["radiance"][seen], emitted, rtol=0.02)  # nothing else is lit
        np.testing.assert_allclose(out["albedo"][seen], np.tile(0.5 * linear["albedo"], (seen.sum(), 1)), rtol=0.02)


def test_radiance_is_material_times_lighting_at_both_resolutions(painted):
    view = camera((0, 0, 0), turn(0.1, -0.05))
    with Renderer(painted, 64) as draw:
        low = draw.low(still(view, FRAME), 2, (0.1, -0.2), 0.0, LOW)
        high = draw.high(still(view, FRAME), 3, 0.0, HIGH)
    for radiance, material, emission in (
        (low["radiance"], low["material"], low["emission"]),
        (high["target_radiance"], high["high_material"], high["high_emission"]),
    ):
        given = [_tensor(v) for v in (radiance, material, emission)]
        lighting = demodulate(*given)
        back = remodulate(lighting, given[1], given[2])
        assert torch.isfinite(lighting).all()
        solid = given[1] > 1e-3
        assert solid.float().mean() > 0.3
        torch.testing.assert_close(back[solid], given[0][solid], rtol=1e-5, atol=1e-6)


def test_high_resolution_materials_are_means_of_the_samples(painted):
    view = camera((0, 0, 0), turn(0.1, -0.05))
    grid = [(i + 0.5) / 3 - 0.5 for i in range(3)]
    with Renderer(painted, 64) as draw:
        high = draw.high(still(view, FRAME), 3, 0.0, HIGH)
        ones = [draw.low(still(view, FRAME), 1, (x, y), 0.0, LOW) for x in grid for y in grid]
        centre = draw.low(still(view, FRAME), 1, (0.0, 0.0), 0.0, LOW)
    for name in ("albedo", "material", "emission", "n_dot_v", "roughness"):
        difference = np.abs(high[f"high_{name}"] - np.mean([one[name] for one in ones], axis=0))
        assert (difference > 2e-3).mean() < 0.01, name
    for name in ("depth", "motion", "normal", "object_id"):
        np.testing.assert_array_equal(high[f"high_{name}"], centre[name])


def test_an_element_of_the_interface_shows_over_what_it_leaves_alone():
    """It covers wall and sky, has no depth, motion or id, receives no light, and stays behind nearer surfaces."""
    board = glow(0.25, interface=True)
    paint = Material("paint", base_color=(0.8, 0.8, 0.8), double_sided=True)
    post = glow(4.0)
    meshes = [wall(-4, 4, -4, 0, -6, 1), wall(-1, 1, -1, 1, -3, 0), wall(-0.2, 0.2, -4, 4, -2, 2)]
    now, before = camera(), camera((0.2, 0.0, 0.0))
    shot = Shot(now, before, 0.0, 0.0, FRAME)
    with_board = scene([board, paint, post], meshes, sky=WHITE)
    without = scene([paint, post], [wall(-4, 4, -4, 0, -6, 0), wall(-0.2, 0.2, -4, 4, -2, 1)], sky=WHITE)
    with Renderer(with_board, 64) as draw:
        out = draw.low(shot, 1, (0.0, 0.0), 0.0, LOW)
    with Renderer(without, 64) as draw:
        plain = draw.low(shot, 1, (0.0, 0.0), 0.0, LOW)
    for name in ("depth", "motion", "motion_dual", "normal", "albedo"):
        np.testing.assert_array_equal(out[name], plain[name])
    covered = np.all(np.isclose(out["emission"], 0.25, atol=1e-3), axis=-1)
    size = round(96 / 2 / np.tan(0.5) / 3)  # half a metre's worth of pixels at 3 m, per metre
    middle = covered[48 - size // 2 : 48 + size // 2]
    assert 0.2 < covered.mean() < 0.5
    assert not middle[:, 46:50].any()  # the post is in front
    np.testing.assert_array_equal(out["radiance"][covered], out["emission"][covered])
    assert (out["material"][covered] == 0).all()
    assert {float(v) for v in np.unique(out["object_id"])} == {0.0, 1.0, 3.0}


@pytest.mark.parametrize("frame", ["camera", "billboard"])
def test_what_is_fixed_to_the_camera_stays_in_the_image(frame):
    meshes = [wall(-0.2, 0.2, -0.2, 0.2, 0.0, 0), wall(-30, 30, -30, 30, -20, 1)]
    place = shift(0.3, 0.1, -2.0) if frame == "camera" else shift(1.0, 0.5, -4.0)
    world = scene([glow(1.0), glow(0.01)], meshes)
    objects = [Object((0,), place, frame), Object((1,), np.eye(4, dtype=np.float32))]
    world = Scene("sign", world.materials, world.meshes, objects, (), sun=None, sky=DARK, near=0.5, far=50.0)
    spans = []
    with Renderer(world, 64) as draw:
        for view in (camera(), camera((0.4, -0.2, 0.3), turn(0.15, 0.1))):
            image = draw.low(still(view, FRAME), 1, (0.0, 0.0), 0.0, frozenset({"color", "motion"}))
            lit = image["color"][..., 0] > 0.5
            rows, columns = np.flatnonzero(lit.any(1)), np.flatnonzero(lit.any(0))
            spans.append((rows[0], rows[-1], columns[0], columns[-1]))
            assert lit[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].all()  # upright and facing
    if frame == "camera":
        assert spans[0] == spans[1]
    else:
        assert spans[0] != spans[1]


def test_a_spot_shines_within_its_cone():
    bulb = PointLight((0.0, 2.0, 0.0), (2.0,) * 3, 8.0, False, (0.0, -1.0, 0.0), (0.3, 0.5))
    paint = Material("paint", base_color=(0.5, 0.5, 0.5), roughness=1.0)
    plain = PointLight((0.0, 2.0, 0.0), (2.0,) * 3, 8.0, False)
    view = camera((0, 3.0, 0.0), turn(0.0, -np.pi / 2), fov=1.2)
    images = []
    for light in (bulb, plain):
        with Renderer(scene([paint], [floor(4.0)], points=[light]), 64) as draw:
            out = draw.low(still(view, whole(96, 96)), 1, (0.0, 0.0), 0.0, frozenset({"radiance"}))
            images.append(out["radiance"][..., 0])
    y, x = np.mgrid[0:96, 0:96] + 0.5 - 48
    radius = np.hypot(x, y) * 2 * 3.0 * np.tan(0.6) / 96  # metres on the floor
    angle = np.arctan2(radius, 2.0)
    scale = 1 / (np.cos(0.3) - np.cos(0.5))
    expected = np.clip((np.cos(angle) - np.cos(0.5)) * scale, 0, 1) ** 2
    np.testing.assert_allclose(images[0], images[1] * expected, atol=0.02 * images[1].max())


@pytest.mark.parametrize("jitter", [(0.0, 0.0), (0.3, -0.4)])
@pytest.mark.parametrize("step", [(5, 0), (-3, 4)])
def test_dual_motion_marks_exactly_the_band_behind_a_sliding_square(step, jitter):
    """NSRD supplement, section 2: a square of 30 pixels slides over a plane by whole pixels, its edges between
    pixels."""
    pixel = 2 * 3.0 * np.tan(0.5) / 96  # metres a pixel at the square's distance
    square = wall(-15 * pixel, 15 * pixel, -15 * pixel, 15 * pixel, -3.0, 1)

    def slide(seconds: float) -> np.ndarray:
        return shift(step[0] * pixel * seconds, -step[1] * pixel * seconds, 0.0)

    world = scene([glow(0.3), glow(0.8)], [wall(-9, 9, -9, 9, -6), square], [shift(0, 0, 0), slide])
    shot = Shot(camera(), camera(), 1.0, 0.0, FRAME)
    names = frozenset({"motion", "motion_dual", "object_id"})
    with Renderer(world, 64) as draw:
        out = draw.low(shot, 1, jitter, 0.0, names)
    rows, columns = np.mgrid[0:96, 0:96]

    def covered(x: int, y: int) -> np.ndarray:
        return (np.abs(columns + 0.5 - 48 - x) < 15) & (np.abs(rows + 0.5 - 48 - y) < 15)

    now = covered(*step)
    np.testing.assert_array_equal(out["object_id"][..., 0] == 2, now)
    difference = np.abs(out["motion_dual"] - out["motion"]) * 96
    np.testing.assert_array_equal((difference >= 0.1).any(axis=-1), covered(0, 0) & ~now)
