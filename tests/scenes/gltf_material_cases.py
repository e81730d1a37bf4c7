"""Files of the rows about materials and textures in docs/gltf.md."""

from typing import Any

import numpy as np
from gltf_cases import case
from gltf_files import SQUARE_UV, Builder, data_uri, png

from supersampling.scenes.gltf.features import Deviation

NOISE = np.random.default_rng(3).integers(0, 256, (4, 6, 4), dtype=np.uint8)


def _square(file: Builder, scale: float = 1.0, **material: Any) -> None:
    """Add a square; its texture coordinates are scaled."""
    uv = file.accessor(np.array(SQUARE_UV) * scale)
    file.node(mesh=file.square(file.material(**material), TEXCOORD_0=uv))


def _base(file: Builder, pixels: Any = NOISE, **more: Any) -> dict[str, Any]:
    return {"baseColorTexture": {"index": file.texture(pixels, **more)}}


@case("Factors and textures of base colour, metalness and roughness")
def metallic_roughness(file: Builder, plain: Builder) -> None:
    """Constant textures in one file, the factors that they stand for in the other."""
    pixels = np.full((2, 2, 3), (0, 51, 204), np.uint8)
    pbr = {"metallicRoughnessTexture": {"index": file.texture(pixels)}, "metallicFactor": 0.5}
    _square(file, pbrMetallicRoughness=pbr)
    pbr = {"metallicRoughnessTexture": {"index": plain.texture(pixels)}, "metallicFactor": 0.5, "roughnessFactor": 1.0}
    _square(plain, pbrMetallicRoughness={**pbr, "baseColorFactor": [1.0, 1.0, 1.0, 1.0]})


@case("The default material")
def default(file: Builder, plain: Builder) -> None:
    file.node(mesh=file.square())
    _square(plain, pbrMetallicRoughness={"metallicFactor": 1.0, "roughnessFactor": 1.0})


@case("Normal maps and their scale")
def normal_scale(file: Builder, plain: Builder) -> None:
    steep, flat = (np.full((2, 2, 3), pixel, np.uint8) for pixel in ((191, 128, 238), (163, 128, 250)))
    _square(file, normalTexture={"index": file.texture(steep), "scale": 0.5})
    _square(plain, normalTexture={"index": plain.texture(flat)})


@case("Emissive factors and textures")
def emission(file: Builder, plain: Builder) -> None:
    white = {"index": file.texture(np.full((1, 1, 3), 255, np.uint8))}
    _square(file, emissiveFactor=[0.5, 0.25, 0.0], emissiveTexture=white)
    _square(plain, emissiveFactor=[0.5, 0.25, 0.0])


@case("Emissions brighter than 60000", Deviation.EMISSION)
def bright(file: Builder) -> None:
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 7e4}}
    _square(file, emissiveFactor=[1.0, 1.0, 1.0], extensions=strength)


@case("Alpha modes OPAQUE and MASK, with factor, texture and vertex colours")
def masks(file: Builder, plain: Builder) -> None:
    pbr = {"baseColorFactor": [1.0, 1.0, 1.0, 0.5], **_base(file)}
    _square(file, pbrMetallicRoughness=pbr, alphaMode="MASK", alphaCutoff=0.25)
    _square(file, pbrMetallicRoughness=pbr)
    _square(plain, pbrMetallicRoughness=_base(plain), alphaMode="MASK")
    _square(plain, pbrMetallicRoughness=_base(plain, NOISE[..., :3]), alphaMode="OPAQUE")


@case("Alpha mode BLEND", Deviation.BLENDING)
def blending(file: Builder) -> None:
    _square(file, pbrMetallicRoughness=_base(file), alphaMode="BLEND")


@case("Unknown alpha modes", error="unknown alphaMode ADD")
def unknown_alpha(file: Builder) -> None:
    _square(file, alphaMode="ADD")


@case("Double-sided materials")
def double_sided(file: Builder, plain: Builder) -> None:
    _square(file, doubleSided=False)
    _square(plain)


@case("Occlusion maps", Deviation.OCCLUSION)
def occlusion(file: Builder) -> None:
    _square(file, occlusionTexture={"index": file.texture(NOISE), "strength": 0.5})


@case("Filters, with and without mipmaps")
def filters(file: Builder, plain: Builder) -> None:
    """A file without filters leaves them to us, which are linear ones with mipmaps."""
    sampler = file.add("samplers", {"magFilter": 9729, "minFilter": 9987})
    _square(file, pbrMetallicRoughness=_base(file, sampler=sampler))
    _square(plain, pbrMetallicRoughness=_base(plain))


@case("Wrapping: repeating, mirrored, clamped to the edge")
def wrapping(file: Builder, plain: Builder) -> None:
    mirrored = file.add("samplers", {"wrapS": 33648, "wrapT": 10497})
    _square(file, 4.0, pbrMetallicRoughness=_base(file, NOISE, sampler=mirrored))
    both = np.concatenate([NOISE, NOISE[:, ::-1]], axis=1)
    uv = plain.accessor(np.array(SQUARE_UV) * [2.0, 4.0])
    plain.node(mesh=plain.square(plain.material(pbrMetallicRoughness=_base(plain, both)), TEXCOORD_0=uv))


@case("Unknown filters and wrapping", error="unknown filter or wrapping 1234")
def unknown_filters(file: Builder) -> None:
    _square(file, pbrMetallicRoughness=_base(file, sampler=file.add("samplers", {"wrapS": 1234})))


@case("Textures of a material with different samplers", Deviation.SAMPLERS)
def samplers(file: Builder) -> None:
    sampler = file.add("samplers", {"magFilter": 9728})
    normal = {"index": file.texture(NOISE, sampler=sampler)}
    _square(file, pbrMetallicRoughness=_base(file), normalTexture=normal)


@case("Textures of a material with different coordinates", Deviation.COORDINATES)
def coordinates(file: Builder) -> None:
    normal = {"index": file.texture(NOISE), "texCoord": 1}
    _square(file, pbrMetallicRoughness=_base(file), normalTexture=normal)


@case("Offset, rotation, scale and set of `KHR_texture_transform`")
def transforms(file: Builder, plain: Builder) -> None:
    transform = {"offset": [0.25, 0.0], "scale": [3.0, 3.0], "texCoord": 0}
    info = {"index": file.texture(NOISE), "texCoord": 1, "extensions": {"KHR_texture_transform": transform}}
    _square(file, pbrMetallicRoughness={"baseColorTexture": info})
    uv = plain.accessor(np.array(SQUARE_UV) * 3.0 + [0.25, 0.0])
    plain.node(mesh=plain.square(plain.material(pbrMetallicRoughness=_base(plain)), TEXCOORD_0=uv))


@case("PNG and JPEG images: files, data URIs and buffer views")
def images(file: Builder, plain: Builder) -> None:
    image = file.add("images", {"uri": data_uri(png(NOISE), "image/png")})
    _square(file, pbrMetallicRoughness={"baseColorTexture": {"index": file.add("textures", {"source": image})}})
    _square(plain, pbrMetallicRoughness=_base(plain))


@case("Images of more than 4096 pixels per side", Deviation.LARGE_IMAGES)
def large_images(file: Builder) -> None:
    _square(file, pbrMetallicRoughness=_base(file, np.zeros((1, 4098, 3), np.uint8)))


@case("Textures without an image", Deviation.IMAGES)
def no_image(file: Builder) -> None:
    _square(file, pbrMetallicRoughness={"baseColorTexture": {"index": file.add("textures", {})}})


@case("Images of other kinds", error="neither PNG nor JPEG")
def other_images(file: Builder) -> None:
    image = file.add("images", {"uri": data_uri(png(NOISE[..., :3], "BMP"))})
    _square(file, pbrMetallicRoughness={"baseColorTexture": {"index": file.add("textures", {"source": image})}})


@case("`KHR_materials_unlit`, with texture and vertex colours")
def unlit(file: Builder, plain: Builder) -> None:
    """Occlusion and emission have no effect on it."""
    extra = {"emissiveFactor": [1.0, 1.0, 1.0], "occlusionTexture": {"index": file.texture(NOISE)}}
    for builder, more in ((file, extra), (plain, {})):
        material = builder.material(pbrMetallicRoughness=_base(builder), extensions={"KHR_materials_unlit": {}}, **more)
        builder.node(mesh=builder.square(material, COLOR_0=builder.accessor([[0.5, 1.0, 0.0]] * 4)))


@case("`KHR_materials_emissive_strength`")
def strength(file: Builder, plain: Builder) -> None:
    extension = {"KHR_materials_emissive_strength": {"emissiveStrength": 0.5}}
    _square(file, emissiveFactor=[1.0, 0.5, 0.0], extensions=extension)
    _square(plain, emissiveFactor=[0.5, 0.25, 0.0])
