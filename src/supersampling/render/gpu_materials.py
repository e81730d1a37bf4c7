"""Materials of a scene on the GPU: all factors in one uniform buffer, each map as a texture of its size."""

from collections.abc import Sequence

import moderngl
import numpy as np

from supersampling.scenes.scene import Material, Texture

_SRGB8_ALPHA8 = 0x8C43
_UNIFORM_ALIGNMENT = 256
_BLOCK_BYTES = 48  # MaterialBlock of gbuffer_fragment.glsl
_WHITE: Texture = np.full((1, 1, 4), 255, np.uint8)


class GpuMaterials:
    """Uploaded materials; ``albedo`` has one texture per material, white if the material has no albedo map."""

    def __init__(self, ctx: moderngl.Context, materials: Sequence[Material]) -> None:
        self._ctx = ctx
        self._buffer = ctx.buffer(_block(materials))
        self._textures: dict[tuple[int, bool], moderngl.Texture] = {}
        white = self._texture(_WHITE, srgb=True)
        self.albedo = [white if m.albedo is None else self._texture(m.albedo, srgb=True) for m in materials]
        self._normal = self._upload([m.normal for m in materials], srgb=False)
        self._surface = self._upload([m.surface for m in materials], srgb=False)
        self._glow = self._upload([m.glow for m in materials], srgb=True)

    def bind(self, material: int) -> None:
        """Bind the factors of one material to uniform block 0."""
        self._buffer.bind_to_uniform_block(0, offset=material * _UNIFORM_ALIGNMENT, size=_BLOCK_BYTES)

    def maps(self, material: int) -> tuple[moderngl.Texture | None, ...]:
        """Return the albedo, normal, surface and glow map of one material."""
        return tuple(maps[material] for maps in (self.albedo, self._normal, self._surface, self._glow))

    def _upload(self, images: Sequence[Texture | None], srgb: bool) -> list[moderngl.Texture | None]:
        return [None if image is None else self._texture(image, srgb) for image in images]

    def _texture(self, image: Texture, srgb: bool) -> moderngl.Texture:
        """Return a mipmapped, repeating texture, shared by materials that share an array (kept alive by the scene)."""
        key = (id(image), srgb)
        if key not in self._textures:
            height, width = image.shape[:2]
            if image.shape[2] == 3:
                # Four channels: three-channel formats are slower and not renderable for mipmaps.
                image = np.concatenate([image, np.full((height, width, 1), 255, np.uint8)], axis=2)
            data = np.ascontiguousarray(image).tobytes()
            texture = self._ctx.texture((width, height), 4, data, internal_format=_SRGB8_ALPHA8 if srgb else None)
            texture.build_mipmaps()
            texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
            self._textures[key] = texture
        return self._textures[key]


def _block(materials: Sequence[Material]) -> bytes:
    block = np.zeros((max(len(materials), 1), _UNIFORM_ALIGNMENT // 4), dtype=np.float32)
    for row, m in zip(block, materials):
        cutoff = 0.5 if m.alpha == "blend" else m.alpha_cutoff
        row[: _BLOCK_BYTES // 4] = [
            *(*m.base_color, 1.0),
            *(*m.emission, float(m.double_sided)),
            *(m.roughness, m.metallic, cutoff, float(m.interface)),
        ]
    return block.tobytes()
