"""Materials and textures against the specification's formulas, and their renderings."""

import io
from pathlib import Path

import numpy as np
import pytest
from gltf_files import SQUARE_UV, Builder, data_uri, front_shot, png
from PIL import Image

from supersampling.render.renderer import Renderer
from supersampling.scenes.gltf import load_gltf
from supersampling.scenes.scene import Material, Scene

CHECKS = np.random.default_rng(0).integers(0, 256, (8, 4, 4), dtype=np.uint8)
COLOR = frozenset({"color"})


def linear(srgb: np.ndarray) -> np.ndarray:
    x = srgb.astype(np.float64) / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def scene_with(file: Builder, path: Path, **material: object) -> Scene:
    file.node(mesh=file.square(file.material(**material)))
    return load_gltf(file.glb(path / "a.glb"))


def material_of(file: Builder, path: Path, **material: object) -> Material:
    (made,) = scene_with(file, path, **material).materials
    return made


def emission_of(made: Material) -> np.ndarray:
    """Return a material's emission: emission * glow, or without glow emission * albedo * blue of the surface map."""
    if made.glow is not None:
        return np.array(made.emission) * linear(made.glow)
    albedo = np.ones((1, 1, 3)) if made.albedo is None else linear(made.albedo[..., :3])
    mask = np.ones((1, 1, 1)) if made.surface is None else made.surface[..., 2:] / 255.0
    return np.array(made.emission) * albedo * mask


def test_factors_and_maps(tmp_path: Path) -> None:
    file = Builder()
    pbr = {
        "baseColorFactor": [0.5, 0.25, 1.0, 0.3], "metallicFactor": 0.75, "roughnessFactor": 0.5,
        "baseColorTexture": {"index": file.texture(CHECKS)},
        "metallicRoughnessTexture": {"index": file.texture(CHECKS[..., :3])},
    }  # fmt: skip
    normal = {"index": file.texture(CHECKS[..., :3])}
    made = material_of(file, tmp_path, name="m", pbrMetallicRoughness=pbr, normalTexture=normal, doubleSided=True)
    assert made.albedo is not None
    assert made.surface is not None
    assert made.normal is not None
    np.testing.assert_array_equal(made.albedo, CHECKS[..., :3])
    np.testing.assert_array_equal(made.normal, CHECKS[..., :3])
    np.testing.assert_array_equal(made.surface[..., 0], CHECKS[..., 1])  # roughness is green
    np.testing.assert_array_equal(made.surface[..., 1], CHECKS[..., 2])  # metallic is blue
    assert (made.surface[..., 2] == 255).all()
    assert (made.base_color, made.metallic, made.roughness) == ((0.5, 0.25, 1.0), 0.75, 0.5)
    assert (made.alpha, made.double_sided, made.emission) == ("opaque", True, (0.0, 0.0, 0.0))


def test_the_default_material_is_a_rough_white_metal(tmp_path: Path) -> None:
    file = Builder()
    file.node(mesh=file.square())
    (made,) = load_gltf(file.glb(tmp_path / "a.glb")).materials
    assert (made.base_color, made.metallic, made.roughness) == ((1.0, 1.0, 1.0), 1.0, 1.0)


def test_images_of_every_kind_become_eight_bit_rgb(tmp_path: Path) -> None:
    grey = np.full((4, 4, 3), 128, np.uint8)
    deep = io.BytesIO()
    Image.fromarray(np.full((4, 4), 128 * 257, np.uint16)).save(deep, "PNG")
    palette = io.BytesIO()
    Image.fromarray(grey).quantize(2).save(palette, "PNG")
    kinds = (png(grey), png(grey, "JPEG"), png(grey[..., 0]), deep.getvalue(), palette.getvalue())
    (tmp_path / "beside.png").write_bytes(kinds[0])
    file = Builder()
    images: list[dict[str, int | str]] = [{"bufferView": file.view(data)} for data in kinds]
    images += [{"uri": "beside.png"}, {"uri": data_uri(kinds[1], "image/jpeg")}]
    for image in images:
        texture = file.add("textures", {"source": file.add("images", image)})
        file.node(mesh=file.square(file.material(pbrMetallicRoughness={"baseColorTexture": {"index": texture}})))
    made = load_gltf(file.glb(tmp_path / "a.glb")).materials
    assert len(made) == 7
    for material in made:
        assert material.albedo is not None
        np.testing.assert_allclose(material.albedo, grey, atol=1)


@pytest.mark.parametrize("factor", [1.0, 0.5, 0.8])
def test_masks_compare_factor_times_texture_with_the_cutoff(factor: float, tmp_path: Path) -> None:
    file = Builder()
    pbr = {"baseColorFactor": [1, 1, 1, factor], "baseColorTexture": {"index": file.texture(CHECKS)}}
    made = material_of(file, tmp_path, pbrMetallicRoughness=pbr, alphaMode="MASK", alphaCutoff=0.3)
    assert made.albedo is not None
    assert made.alpha == "test"
    kept = made.albedo[..., 3] / 255.0 >= made.alpha_cutoff
    np.testing.assert_array_equal(kept, factor * CHECKS[..., 3] / 255.0 >= 0.3)


def test_blended_alpha_carries_its_factor(tmp_path: Path) -> None:
    pbr = {"baseColorFactor": [1, 1, 1, 0.2]}
    with pytest.warns(UserWarning, match="blending is drawn as a test at half opacity"):
        made = material_of(Builder(), tmp_path, pbrMetallicRoughness=pbr, alphaMode="BLEND")
    assert made.alpha == "blend"
    assert made.albedo is not None
    np.testing.assert_array_equal(made.albedo, [[[255, 255, 255, 51]]])


def test_plain_emission_with_strength(tmp_path: Path) -> None:
    extension = {"KHR_materials_emissive_strength": {"emissiveStrength": 5.0}}
    made = material_of(Builder(), tmp_path, emissiveFactor=[1.0, 0.5, 0.0], extensions=extension)
    np.testing.assert_allclose(emission_of(made), [[[5.0, 2.5, 0.0]]])


@pytest.mark.parametrize("base", [(0, 0, 0), (180, 40, 30)])
def test_an_emissive_texture_is_seen_exactly_and_leaves_the_surface_alone(
    base: tuple[int, int, int], tmp_path: Path
) -> None:
    """A black screen, and lamps on a painted wall. A texel of `CHECKS` is a block of texels, seen at its middle."""
    file = Builder()
    paint = np.full((2, 2, 3), base, np.uint8)
    glow = np.kron(CHECKS[..., :3], np.ones((8, 8, 1), np.uint8))
    scene = scene_with(
        file,
        tmp_path,
        pbrMetallicRoughness={"baseColorTexture": {"index": file.texture(paint)}, "metallicFactor": 0.0},
        emissiveTexture={"index": file.texture(glow)},
        emissiveFactor=[1.0, 0.5, 0.25],
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 8.0}},
    )
    shot = front_shot(1.0, 96, 96, np.pi / 2)  # the square fills the image
    with Renderer(scene, 64) as renderer:
        out = renderer.low(shot, 1, (0.0, 0.0), 0.0, frozenset({"emission", "albedo"}))
    expected = np.array((8.0, 4.0, 2.0)) * linear(CHECKS[..., :3]) * scene.exposure
    np.testing.assert_allclose(out["emission"][6::12, 12::24], expected, rtol=0.02, atol=2e-3)
    np.testing.assert_allclose(out["albedo"].reshape(-1, 3), np.tile(linear(paint[0, 0]), (96 * 96, 1)), atol=2e-3)


def test_a_plain_emission_takes_no_colour_from_the_base(tmp_path: Path) -> None:
    file = Builder()
    pbr = {"baseColorTexture": {"index": file.texture(CHECKS)}}
    made = material_of(file, tmp_path, pbrMetallicRoughness=pbr, emissiveFactor=[0.5, 1.0, 0.25])
    np.testing.assert_allclose(emission_of(made), [[[0.5, 1.0, 0.25]]])
    assert made.albedo is not None
    np.testing.assert_array_equal(made.albedo, CHECKS[..., :3])


def test_an_emissive_map_with_other_coordinates_takes_the_emission_with_it(tmp_path: Path) -> None:
    file = Builder()
    pbr = {"baseColorTexture": {"index": file.texture(CHECKS)}}
    transform = {"KHR_texture_transform": {"scale": [2.0, 2.0]}}
    glow = {"index": file.texture(CHECKS), "extensions": transform}
    with pytest.warns(UserWarning, match="other coordinates"):
        made = material_of(file, tmp_path, pbrMetallicRoughness=pbr, emissiveTexture=glow, emissiveFactor=[1, 1, 1])
    assert (made.glow, made.emission) == (None, (0.0, 0.0, 0.0))


def test_unlit_shows_its_colour_and_nothing_else(tmp_path: Path) -> None:
    file = Builder()
    pbr = {"baseColorFactor": [0.5, 0.5, 0.5, 1.0], "baseColorTexture": {"index": file.texture(CHECKS[..., :3])}}
    made = material_of(file, tmp_path, pbrMetallicRoughness=pbr, extensions={"KHR_materials_unlit": {}})
    np.testing.assert_allclose(emission_of(made), 0.5 * linear(CHECKS[..., :3]), atol=1e-6)
    assert made.base_color == (0.0, 0.0, 0.0)


def test_normal_scale_flattens_slopes(tmp_path: Path) -> None:
    steep = np.array((0.6, 0.0, 0.8))
    file = Builder()
    texel = np.tile(np.round((steep + 1.0) * 127.5), (2, 2, 1))
    made = material_of(file, tmp_path, normalTexture={"index": file.texture(texel), "scale": 0.5})
    flat = steep * [0.5, 0.5, 1.0]
    assert made.normal is not None
    np.testing.assert_allclose(made.normal[0, 0] / 127.5 - 1.0, flat / np.linalg.norm(flat), atol=0.01)


def test_a_transform_beyond_float32_is_noted(tmp_path: Path) -> None:
    file = Builder()
    info = {"index": file.texture(CHECKS), "extensions": {"KHR_texture_transform": {"scale": [3e38, 1]}}}
    material = file.material(pbrMetallicRoughness={"baseColorTexture": info})
    file.node(mesh=file.square(material, TEXCOORD_0=file.accessor(np.array(SQUARE_UV) * 9.0)))
    with pytest.warns(UserWarning, match="not finite"):
        mesh = load_gltf(file.glb(tmp_path / "a.glb")).meshes[0]
    assert np.isfinite(mesh.uv).all()
    assert mesh.uv[:, 1].max() == 9.0


def test_textures_read_their_set_and_their_transform(tmp_path: Path) -> None:
    """The extension's own example, which shows the lower left quadrant, on the second set of coordinates."""
    file = Builder()
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5], "texCoord": 1}
    info = {"index": file.texture(CHECKS), "extensions": {"KHR_texture_transform": transform}}
    second = file.accessor(np.array(SQUARE_UV))
    first = file.accessor(np.full((4, 2), 7.0))
    material = file.material(pbrMetallicRoughness={"baseColorTexture": info})
    file.node(mesh=file.square(material, TEXCOORD_0=first, TEXCOORD_1=second))
    file.json["extensionsRequired"] = ["KHR_texture_transform"]
    (mesh,) = load_gltf(file.glb(tmp_path / "a.glb")).meshes
    # (0, 1), (1, 1), (1, 0), (0, 0) turned within the quadrant of u below and v above a half.
    np.testing.assert_allclose(mesh.uv, [[0.5, 1.0], [0.5, 0.5], [0.0, 0.5], [0.0, 1.0]], atol=1e-6)


def test_maps_with_other_coordinates_are_left_out_with_a_warning(tmp_path: Path) -> None:
    file = Builder()
    pbr = {"baseColorTexture": {"index": file.texture(CHECKS)}}
    normal = {"index": file.texture(CHECKS), "texCoord": 1}
    with pytest.warns(UserWarning, match="other coordinates"):
        made = material_of(file, tmp_path, pbrMetallicRoughness=pbr, normalTexture=normal)
    assert made.normal is None


def test_credit_comes_from_the_file(tmp_path: Path) -> None:
    file = Builder()
    file.json["asset"] |= {"copyright": "2017 Somebody", "generator": "Some tool", "extras": {"license": "CC0"}}
    scene = scene_with(file, tmp_path)
    for part in ("2017 Somebody", "Some tool", "CC0"):
        assert part in scene.attribution
