"""Conversion of glTF's materials to the scene's (specification, section 3.9)."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from io import BytesIO
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from supersampling.errors import UserError
from supersampling.scenes.gltf.coordinates import Coordinates, Sampler, coordinates, read_sampler
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.gltf.features import Deviation
from supersampling.scenes.gltf.images import Images
from supersampling.scenes.gltf.notes import Notes
from supersampling.scenes.scene import Material, Texture

_ALPHA: dict[str, Literal["opaque", "test", "blend"]] = {"OPAQUE": "opaque", "MASK": "test", "BLEND": "blend"}

_BRIGHTEST = 6e4  # radiance that a half float can represent
_WHITE: Texture = np.full((1, 1, 3), 255, np.uint8)


class MaterialReader:
    """Reader that converts each material once; ``materials`` are the scene's materials.

    The maps of a material share one set of texture coordinates and one sampler: that of the first of base colour,
    metallic-roughness, normal and emissive texture. A map with other coordinates is left out and noted; an emission is
    left out with its map.
    """

    def __init__(self, document: Document, notes: Notes) -> None:
        self.materials: list[Material] = []
        self._document, self._notes = document, notes
        self._images = Images(document)
        self._image = cache(self._read_image)
        self._known: dict[int | None, tuple[int, Coordinates, Sampler]] = {}

    def number(self, index: int | None) -> tuple[int, Coordinates, Sampler]:
        """Return a material's index in ``materials``, its texture coordinates and sampler; None is glTF's default."""
        if index not in self._known:
            material, uv, sampler = self._read(index)
            self._known[index] = (len(self.materials), uv, sampler)
            self.materials.append(material)
        return self._known[index]

    def _read(self, index: int | None) -> tuple[Material, Coordinates, Sampler]:
        if index is None:
            return Material("default", roughness=1.0, metallic=1.0), Coordinates(), Sampler()
        source = self._document.item("materials", index)
        slots = _Slots(self._document, self._image, self._notes)
        pbr = source.pbrMetallicRoughness
        color, alpha = self._factors(index, [1.0] * 4 if pbr is None else pbr.baseColorFactor or [1.0] * 4)
        mode = _ALPHA.get(source.alphaMode or "OPAQUE")
        if mode is None:
            raise UserError(
                f"Material {index} of {self._document.name} has the unknown alphaMode {source.alphaMode}: "
                "use OPAQUE, MASK or BLEND."
            )
        if mode == "blend":
            self._notes.add(Deviation.BLENDING)
        if source.occlusionTexture is not None and "KHR_materials_unlit" not in (source.extensions or {}):
            self._notes.add(Deviation.OCCLUSION)
        albedo = None if pbr is None else slots.image(pbr.baseColorTexture, alpha=mode != "opaque")
        surface = None if pbr is None else slots.image(pbr.metallicRoughnessTexture)
        extensions = source.extensions or {}
        strength = float(extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0))
        emission, _ = self._factors(index, source.emissiveFactor or [0.0] * 3)
        albedo, cutoff = _alpha(albedo, alpha, mode, source.alphaCutoff)
        material = Material(
            source.name or f"material {index}",
            albedo,
            slots.normal(source.normalTexture),
            None if surface is None else _swizzled(surface),
            base_color=_triple(color),
            roughness=_share(None if pbr is None else pbr.roughnessFactor),
            metallic=_share(None if pbr is None else pbr.metallicFactor),
            alpha=mode,
            alpha_cutoff=cutoff,
            double_sided=bool(source.doubleSided),
        )
        if "KHR_materials_unlit" in extensions:
            material = _unlit(material)
        elif float(emission.max()) * strength > 0.0:
            material = self._glowing(material, slots.glow(source.emissiveTexture), strength * emission)
        material = replace(material, sampling=slots.sampler.sampling)
        return material, slots.coordinates or Coordinates(), slots.sampler

    def _glowing(self, material: Material, glow: Texture | None, emission: NDArray[np.float64]) -> Material:
        if glow is None:
            return material
        if float(emission.max()) > _BRIGHTEST:
            self._notes.add(Deviation.EMISSION)
        return replace(material, glow=glow, emission=_triple(np.minimum(emission, _BRIGHTEST)))

    def _read_image(self, index: int, alpha: bool, sampler: Sampler) -> Texture:
        image = self._images.rgba(index) if alpha else self._images.rgb(index)
        if max(Image.open(BytesIO(self._images.encoded(index))).size) > max(image.shape[:2]):
            self._notes.add(Deviation.LARGE_IMAGES)
        return sampler.extended(image)

    def _factors(self, index: int, values: list[float]) -> tuple[NDArray[np.float64], float]:
        numbers = np.array([float(v) for v in values])
        if len(numbers) not in (3, 4) or not np.isfinite(numbers).all():
            raise UserError(
                f"Material {index} of {self._document.name} has the invalid colour {values}: "
                "use finite numbers for red, green and blue."
            )
        return np.maximum(numbers[:3], 0.0), float(numbers[3]) if len(numbers) == 4 else 1.0


class _Slots:
    """Texture slots of one material; ``coordinates`` and ``sampler`` are those of the first texture."""

    def __init__(self, document: Document, image: Callable[[int, bool, Sampler], Texture], notes: Notes) -> None:
        self.coordinates: Coordinates | None = None
        self.sampler = Sampler()
        self._document, self._image, self._notes = document, image, notes

    def image(self, info: Any, alpha: bool = False) -> Texture | None:
        """Return ``(H, W, 3)``, or ``(H, W, 4)`` with ``alpha``; None without a usable texture."""
        if info is None or info.index is None:
            return None
        texture = self._document.item("textures", info.index)
        if texture.source is None:
            self._notes.add(Deviation.IMAGES)
            return None
        uv, sampler = coordinates(info), read_sampler(self._document, texture.sampler)
        if self.coordinates is None:
            self.coordinates, self.sampler = uv, sampler
        elif uv != self.coordinates:
            self._notes.add(Deviation.COORDINATES)
            return None
        elif sampler != self.sampler:
            self._notes.add(Deviation.SAMPLERS)
        return self._image(texture.source, alpha, self.sampler)

    def glow(self, info: Any) -> Texture | None:
        """Return white without an emissive texture, None if it cannot be used: the whole surface would glow."""
        return _WHITE if info is None or info.index is None else self.image(info)

    def normal(self, info: Any) -> Texture | None:
        """Return the normal map with its slopes multiplied by ``scale``."""
        texture = self.image(info)
        scale = 1.0 if info is None or info.scale is None else float(info.scale)
        if texture is None or scale == 1.0:
            return texture
        n = texture.astype(np.float32) / 127.5 - 1.0
        n[..., :2] *= scale
        n /= np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-6)
        return np.round((n + 1.0) * 127.5).astype(np.uint8)


def _alpha(albedo: Texture | None, factor: float, mode: str, cutoff: float | None) -> tuple[Texture | None, float]:
    """Return the albedo map and its alpha cutoff for alpha = factor * texture.

    A test compares ``texture < cutoff / factor``; the factor of blended materials is multiplied into the texture.
    """
    cutoff = 0.5 if cutoff is None else float(cutoff)
    if mode == "test":
        # A factor of zero makes everything transparent, unless the cutoff is zero.
        return albedo, cutoff / factor if factor > 0.0 else (2.0 if cutoff > 0.0 else 0.0)
    if mode == "blend" and factor < 1.0:
        albedo = np.full((1, 1, 4), 255, np.uint8) if albedo is None else albedo.copy()
        albedo[..., 3] = np.round(albedo[..., 3] * np.clip(factor, 0.0, 1.0))
    return albedo, 0.5


def _swizzled(texture: Texture) -> Texture:
    """Return roughness and metallic (G and B in glTF) as R and G; B is white, which masks no emission."""
    return np.dstack([texture[..., 1], texture[..., 2], np.full(texture.shape[:2], 255, np.uint8)])


def _unlit(material: Material) -> Material:
    """Return the material with its colour as emission: a black metal reflects almost nothing besides."""
    return replace(
        material,
        normal=None,
        surface=None,
        base_color=(0.0, 0.0, 0.0),
        roughness=1.0,
        metallic=1.0,
        emission=material.base_color,
        colored_emission=True,
    )


def _share(factor: float | None) -> float:
    return 1.0 if factor is None else float(np.clip(factor, 0.0, 1.0))


def _triple(color: NDArray[np.floating]) -> tuple[float, float, float]:
    return (float(color[0]), float(color[1]), float(color[2]))
