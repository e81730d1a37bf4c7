"""SuperTuxKart's materials as metallic-roughness materials.

``materials.xml`` has a shader and the normal and gloss maps for each texture. ``solid``, ``decal``, ``splatting``,
``spheremap`` and unknown shaders are drawn opaque with the first texture; ``alphatest``, ``grass`` and ``unlit``
alpha-tested; ``alphablend`` and ``displace`` (water) alpha-tested at half their typical opacity, which keeps thin water
but not the rim of a cloud. ``additive`` (halos, light shafts) is left out because there is no blending.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from supersampling.scenes.scene import Material, Texture
from supersampling.scenes.stk.data import Assets
from supersampling.scenes.stk.images import masked, read_image, upright_normals
from supersampling.scenes.stk.nodes import parse

_LEFT_OUT = {"additive", "ghost"}
_TESTED = {"alphatest", "grass", "unlit"}
_BLENDED = {"alphablend", "displace"}
_BUMPED = {"solid", "dynamicnightbloom"}
_WATER_ROUGHNESS = 0.2
_PLAIN_ROUGHNESS = 0.84  # without a gloss map the gloss is 0
# combine_diffuse_color.frag: emission e (0.4 for unlit) adds e c (1 + 10 c e^2) for the colour c. Evaluated at c = 0.5;
# the full glow of 6 is limited to 4, since there is no bloom.
_UNLIT_EMISSION = 0.7
_GLOWING_EMISSION = 4.0
# Level of JPEG noise in the emission band of a gloss map without glow.
_DARK = 24

Attributes = Mapping[str, str]


def roughness_of_gloss(gloss: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the GGX roughness with the same highlight width as the game's Blinn-Phong exponent ``2^(10 gloss + 1)``.

    ``alpha^2 = 2 / (exponent + 2)`` (Walter et al. 2007, section 6.3), roughness = sqrt(alpha): 0.84 for gloss 0, 0.18
    for 1.
    """
    return (2.0 / (np.exp2(10.0 * gloss + 1.0) + 2.0)) ** 0.25


def surface_map(gloss: Texture) -> Texture:
    """Convert a gloss map (gloss, metallic, emission) to roughness, metallic, emission: ``(H, W, 3)``."""
    out = gloss[..., :3].copy()
    table = np.round(255.0 * roughness_of_gloss(np.arange(256) / 255.0)).astype(np.uint8)
    out[..., 0] = table[gloss[..., 0]]
    glow = np.where(gloss[..., 2] < _DARK, 0.0, gloss[..., 2] / 255.0)
    out[..., 2] = np.round(255.0 * glow * (1.0 + 5.0 * glow**2) / 6.0)
    return out


class MaterialTable:
    """``<material>`` entries by texture name: first of the library node, then of the track, then of the game."""

    def __init__(self, assets: Assets) -> None:
        self._shared = (assets.track, assets.root / "textures")
        self._tables: dict[Path, dict[tuple[str, str], Attributes]] = {}

    def find(self, textures: tuple[str, str], folder: Path) -> Attributes:
        first, second = (name.lower() for name in textures)
        for location in (folder, *self._shared):
            table = self._table(location)
            for key in ((first, second), (first, "")):
                if key in table:
                    return table[key]
        return {}

    def _table(self, folder: Path) -> dict[tuple[str, str], Attributes]:
        if folder not in self._tables:
            path = folder / "materials.xml"
            entries = parse(path).iter("material") if path.is_file() else ()
            self._tables[folder] = {
                (e.get("name", "").lower(), e.get("uv-two-tex", "").lower()): dict(e.attrib) for e in entries
            }
        return self._tables[folder]


class TrackMaterials:
    """Reader that converts each material once; ``files`` are the images that ``materials`` use.

    Missing images are left out.
    """

    def __init__(self, assets: Assets, by_day: bool) -> None:
        self.materials: list[Material] = []
        self.files: set[Path] = set()
        self._assets = assets
        self._by_day = by_day
        self._table = MaterialTable(assets)
        self._numbers: dict[tuple[object, ...], int] = {}
        self._images: dict[tuple[Path, bool], Texture] = {}
        self._normals: dict[Path, Texture] = {}

    def attributes(self, textures: tuple[str, str], folder: Path) -> Attributes:
        return self._table.find(textures, folder)

    def number(self, textures: tuple[str, str], folder: Path) -> int | None:
        """Return the index in ``materials`` for a buffer's textures; None if the material is not drawn."""
        attributes = self._table.find(textures, folder)
        if attributes.get("shader") in _LEFT_OUT:
            return None
        path = self._assets.texture(textures[0], folder)
        key = (path, tuple(sorted(attributes.items())))
        if key not in self._numbers:
            self._numbers[key] = len(self.materials)
            self.materials.append(self._convert(textures[0], path, attributes, folder))
        return self._numbers[key]

    def _convert(self, name: str, path: Path | None, attributes: Attributes, folder: Path) -> Material:
        shader = attributes.get("shader", "solid")
        cut = shader in _TESTED or shader in _BLENDED
        albedo = None if path is None else self._albedo(path, attributes, cut, folder)
        cutoff = _cutoff(albedo, shader) if cut and albedo is not None else 0.0
        normal = self._normal(attributes.get("normal-map"), folder) if shader in _BUMPED else None
        gloss = self._image(attributes.get("gloss-map"), folder)
        glows = gloss is not None and not (shader == "dynamicnightbloom" and self._by_day)
        emission = _UNLIT_EMISSION if shader == "unlit" else _GLOWING_EMISSION if glows else 0.0
        surface = None if gloss is None else surface_map(gloss)
        if surface is not None and not surface[..., 2].any():
            emission = 0.0
        water = attributes.get("water-splash") == "Y" or shader == "displace"
        return Material(
            name=name or "untextured",
            albedo=albedo,
            normal=normal,
            surface=surface,
            roughness=1.0 if gloss is not None else _WATER_ROUGHNESS if water else _PLAIN_ROUGHNESS,
            metallic=1.0 if gloss is not None else 0.0,
            emission=(emission, emission, emission),
            alpha="test" if cutoff > 0.0 else "opaque",
            alpha_cutoff=cutoff or 0.5,
            double_sided=attributes.get("backface-culling") == "N",
        )

    def _albedo(self, path: Path, attributes: Attributes, cut: bool, folder: Path) -> Texture:
        color = self._load(path, cut)
        mask = self._image(attributes.get("mask"), folder)
        return color if mask is None or not cut else masked(color, mask)

    def _normal(self, name: str | None, folder: Path) -> Texture | None:
        path = self._assets.texture(name, folder) if name else None
        if path is not None and path not in self._normals:
            self._normals[path] = upright_normals(self._load(path, False))
        return None if path is None else self._normals[path]

    def _image(self, name: str | None, folder: Path) -> Texture | None:
        path = self._assets.texture(name, folder) if name else None
        return None if path is None else self._load(path, False)

    def _load(self, path: Path, alpha: bool) -> Texture:
        if (path, alpha) not in self._images:
            self._images[path, alpha] = read_image(path, alpha)
            self.files.add(path)
        return self._images[path, alpha]


def _cutoff(albedo: Texture, shader: str) -> float:
    """Return the alpha below which nothing is drawn; 0 if the texture is opaque everywhere."""
    alpha = albedo[..., 3]
    if alpha.min() == 255:
        return 0.0
    return 0.5 if shader in _TESTED else float(np.percentile(alpha, 95)) / 510.0
