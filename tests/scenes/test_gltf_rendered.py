"""Renderings of glTF files against the same scene built by hand, and against closed forms."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gltf_files import SQUARE, SQUARE_INDICES, SQUARE_UV, Builder, front_shot

from supersampling.render.renderer import Renderer
from supersampling.scenes.gltf import load_gltf
from supersampling.scenes.scene import Material, Mesh, Object, Scene, Sky

DARK = Sky((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
COLOR = frozenset({"color"})


def picture(scene: Scene) -> np.ndarray:
    with Renderer(scene, shadow_size=256) as renderer:
        return renderer.low(front_shot(3.0, 64, 48), 1, (0.0, 0.0), 0.0, COLOR)["color"]


def test_a_textured_square_renders_as_the_scene_built_by_hand(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (16, 16, 3), dtype=np.uint8)
    file = Builder()
    pbr = {"baseColorTexture": {"index": file.texture(pixels)}, "metallicFactor": 0.0, "roughnessFactor": 0.6}
    normal = {"index": file.texture(np.tile(np.array((150, 200, 220)), (4, 4, 1)))}
    material = file.material(pbrMetallicRoughness=pbr, normalTexture=normal)
    half = np.sqrt(0.5)
    tilted = file.node(mesh=file.square(material), rotation=[np.sin(0.3), 0, 0, np.cos(0.3)])
    file.node(children=[tilted], rotation=[0, 0, half, half])
    loaded = load_gltf(file.glb(tmp_path / "a.glb"))
    normals = np.tile(np.array((0, 0, 1), np.float32), (4, 1))
    triangles = np.array(SQUARE_INDICES, np.uint32).reshape(2, 3)
    mesh = Mesh(np.array(SQUARE, np.float32), normals, np.array(SQUARE_UV, np.float32), triangles, 0)
    bump = np.tile(np.array((150, 200, 220), np.uint8), (4, 4, 1))
    c, s = np.cos(0.6), np.sin(0.6)
    # Tilted about x by 0.6, then a quarter turn about z.
    rotation = np.array([[0, -c, s, 0], [1, 0, 0, 0], [0, s, c, 0], [0, 0, 0, 1]], np.float32)
    materials, objects = [Material("m", pixels, bump, roughness=0.6)], [Object((0,), rotation)]
    by_hand = replace(loaded, materials=materials, meshes=[mesh], objects=objects)
    image = picture(loaded)
    np.testing.assert_allclose(image, picture(by_hand), atol=1e-5)
    assert image[12:36, 16:48].std() > 0.05  # the texture is there


def test_unlit_emission_is_all_that_a_dark_scene_shows(tmp_path: Path) -> None:
    file = Builder()
    colour = {"baseColorFactor": [0.2, 0.4, 0.6, 1.0]}
    unlit = file.material(pbrMetallicRoughness=colour, extensions={"KHR_materials_unlit": {}})
    file.node(mesh=file.square(unlit))
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    x = np.array((0.2, 0.4, 0.6))
    x = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)
    expected = 1.055 * x ** (1 / 2.4) - 0.055
    middle = picture(replace(scene, sky=DARK, sun=None))[24, 32]
    np.testing.assert_allclose(middle, expected, atol=2e-3)


BOX = np.array([[x, y, z] for x in (-0.5, 0.9) for y in (-0.5, 0.7) for z in (-0.5, 0.3)])
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]  # outwards
SURFACE = frozenset({"depth", "normal"})


def box(file: Builder, **material: object) -> int:
    triangles = [corner for a, b, c, d in SIDES for corner in (a, b, c, a, c, d)]
    positions = {"POSITION": file.accessor(BOX)}
    return file.mesh(positions, indices=file.accessor(triangles, "u1"), material=file.material(**material))


def surface(scene: Scene, seconds: float, like: Scene) -> dict[str, np.ndarray]:
    """Return the low-resolution buffers at an instant, between the near and far planes of another scene."""
    shot = replace(front_shot(3.0, 64, 48), seconds=seconds, previous_seconds=seconds)
    with Renderer(replace(scene, near=like.near, far=like.far), shadow_size=64) as renderer:
        return renderer.low(shot, 1, (0.0, 0.0), 0.0, SURFACE)


TURNED = [0.2, 0.3, 0.1, 0.927]


def by_itself(file: Builder, signs: list[list[float]]) -> None:
    node = file.node(mesh=box(file), rotation=TURNED, scale=signs[0])
    if len(signs) > 1:
        file.animate(node, "scale", [0.0, 1.0], signs)


def by_its_parent(file: Builder, signs: list[list[float]]) -> None:
    child = file.node(mesh=box(file), rotation=TURNED)
    node = file.node(children=[child], scale=signs[0])
    if len(signs) > 1:
        file.animate(node, "scale", [0.0, 1.0], signs)


@pytest.mark.parametrize("build", [by_itself, by_its_parent])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_box_that_mirrors_in_motion_is_the_box_that_is_mirrored_from_the_start(
    build: Callable[[Builder, list[list[float]]], None], sign: float, tmp_path: Path
) -> None:
    """Before and after the scale along x changes its sign, from either side."""
    moving = Builder()
    build(moving, [[sign, 1.0, 1.0], [-sign, 1.0, 1.0]])
    scene = load_gltf(moving.glb(tmp_path / "a.glb"))
    for seconds, scale in ((0.25, 0.5 * sign), (0.75, -0.5 * sign)):
        still = Builder()
        build(still, [[scale, 1.0, 1.0]])
        images = surface(scene, seconds, scene)
        expected = surface(load_gltf(still.glb(tmp_path / "b.glb")), 0.0, scene)
        assert (images["depth"] < 1.0).mean() > 0.02
        np.testing.assert_allclose(images["depth"], expected["depth"], atol=1e-6)
        np.testing.assert_allclose(images["normal"], expected["normal"], atol=1e-4)
        # Outsides are seen: their normals point to the eye.
        assert (images["normal"][images["depth"][..., 0] < 1.0][:, 2] > 0.0).mean() > 0.98


STRIPES = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]]], np.uint8)


def striped(path: Path, factor: float, **sampler: int) -> np.ndarray:
    """Return the albedo ``(96,)`` indices of the stripe that each column shows, -1 for a mixture."""
    file = Builder()
    info = {"index": file.texture(STRIPES, sampler=file.add("samplers", sampler))}
    material = file.material(pbrMetallicRoughness={"baseColorTexture": info})
    uv = np.array(SQUARE_UV) * factor + [(1.0 - factor) / 2.0, 0.0]
    file.node(mesh=file.square(material, TEXCOORD_0=file.accessor(uv)))
    with Renderer(load_gltf(file.glb(path / "a.glb")), 64) as renderer:
        shot = front_shot(1.0, 96, 8, 2.0 * np.arctan(1.0 / 12.0))  # as wide as the square
        row = renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"albedo"}))["albedo"][4]
    distance = np.abs(row[:, None] - STRIPES[0] / 255.0).max(axis=2)
    return np.where(distance.min(axis=1) < 0.01, distance.argmin(axis=1), -1)


def test_nearest_filters_mix_no_texels(tmp_path: Path) -> None:
    np.testing.assert_array_equal(striped(tmp_path, 1.0, magFilter=9728), np.repeat(range(4), 24))
    assert (striped(tmp_path, 1.0, magFilter=9729) == -1).mean() > 0.5
    # 1.5 texels per pixel: without mipmaps and mixtures each pixel shows a stripe of the texture.
    assert (striped(tmp_path, 36.0, magFilter=9728, minFilter=9728) >= 0).all()
    assert (striped(tmp_path, 36.0, magFilter=9728, minFilter=9987) == -1).all()


@pytest.mark.parametrize(("wrap", "outer"), [(10497, (2, 3, 0, 1)), (33071, (0, 0, 3, 3)), (33648, (1, 0, 3, 2))])
def test_each_wrapping_beyond_the_edges(wrap: int, outer: tuple[int, ...], tmp_path: Path) -> None:
    """Coordinates from -0.5 to 1.5: two stripes before the image, four of it, two after."""
    stripes = striped(tmp_path, 2.0, magFilter=9728, wrapS=wrap)
    np.testing.assert_array_equal(stripes, np.repeat((*outer[:2], 0, 1, 2, 3, *outer[2:]), 12))


@pytest.mark.parametrize("mode", ["MASK", "BLEND", "OPAQUE"])
@pytest.mark.filterwarnings("ignore:.*blending")
def test_opacity_of_vertices_is_tested(mode: str, tmp_path: Path) -> None:
    """Opacity falls from left to right from 1 to 0; the base colour's 0.8 moves the half to 0.375 of the width."""
    file = Builder()
    pbr = {"baseColorFactor": [1.0, 1.0, 1.0, 0.8]}
    opacity = file.accessor([[1, 1, 1, a] for a in (1.0, 0.0, 0.0, 1.0)])
    file.node(mesh=file.square(file.material(pbrMetallicRoughness=pbr, alphaMode=mode), COLOR_0=opacity))
    with Renderer(load_gltf(file.glb(tmp_path / "a.glb")), 64) as renderer:
        shot = front_shot(1.0, 96, 8, 2.0 * np.arctan(1.0 / 12.0))
        depth = renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"depth"}))["depth"][4, :, 0]
    assert (depth < 1.0).sum() == pytest.approx(96 if mode == "OPAQUE" else 36, abs=1)


def test_vertex_colours_tint_unlit_surfaces(tmp_path: Path) -> None:
    file = Builder()
    unlit = file.material(extensions={"KHR_materials_unlit": {}})
    file.node(mesh=file.square(unlit, COLOR_0=file.accessor([[1.0, 0.2, 0.0]] * 4)))
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    with Renderer(scene, 64) as renderer:
        emission = renderer.low(front_shot(3.0, 64, 48), 1, (0.0, 0.0), 0.0, frozenset({"emission"}))["emission"]
    np.testing.assert_allclose(emission[24, 32], [1.0, 0.2, 0.0], atol=1e-3)


def test_tangents_of_the_file_turn_the_normal_map(tmp_path: Path) -> None:
    """The map leans along its x, which the file's tangents turn to the world's y."""
    file = Builder()
    leaning = np.full((2, 2, 3), (217, 128, 217), np.uint8)
    material = file.material(normalTexture={"index": file.texture(leaning)})
    file.node(mesh=file.square(material, TANGENT=file.accessor([[0.0, 1.0, 0.0, 1.0]] * 4)))
    scene = load_gltf(file.glb(tmp_path / "a.glb"))
    x, y, z = surface(scene, 0.0, scene)["normal"][24, 32]
    # Buffers have y down.
    np.testing.assert_allclose([x, -y, z], [0.0, 0.5**0.5, 0.5**0.5], atol=0.01)
