"""Renderings of glTF files against the same scene built by hand, and against closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
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
