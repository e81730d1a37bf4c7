"""Materials of a scene on the GPU: all factors in one uniform buffer, each map as a texture of its size."""

from collections.abc import Sequence

import moderngl
import numpy as np

from supersampling.scenes.scene import Material, Sampling, Texture

_SRGB8_ALPHA8 = 0x8C43
_UNIFORM_ALIGNMENT = 256
_BLOCK_BYTES = 48  # MaterialBlock of gbuffer_fragment.glsl
_WHITE: Texture = np.full((1, 1, 4), 255, np.uint8)
_Maps = list[moderngl.Texture | None]


class GpuMaterials:
    """Uploaded materials; ``albedo`` has one texture per material, white if the material has no albedo map."""

    def __init__(self, ctx: moderngl.Context, materials: Sequence[Material]) -> None:
        self._ctx = ctx
        self._buffer = ctx.buffer(_block(materials))
        self._textures: dict[tuple[int, bool, Sampling], moderngl.Texture] = {}
        sampling = [m.sampling for m in materials]
        self.albedo = [
            self._texture(_WHITE if m.albedo is None else m.albedo, m.sampling, srgb=True) for m in materials
        ]
        self._normal = self._upload([m.normal for m in materials], sampling, srgb=False)
        self._surface = self._upload([m.surface for m in materials], sampling, srgb=False)
        self._glow = self._upload([m.glow for m in materials], sampling, srgb=True)

    def bind(self, material: int) -> None:
        """Bind the factors of one material to uniform block 0."""
        self._buffer.bind_to_uniform_block(0, offset=material * _UNIFORM_ALIGNMENT, size=_BLOCK_BYTES)

    def maps(self, material: int) -> tuple[moderngl.Texture | None, ...]:
        """Return the albedo, normal, surface and glow map of one material."""
        return tuple(maps[material] for maps in (self.albedo, self._normal, self._surface, self._glow))

    def _upload(self, images: Sequence[Texture | None], sampling: Sequence[Sampling], *, srgb: bool) -> _Maps:
        return [None if image is None else self._texture(image, s, srgb=srgb) for image, s in zip(images, sampling)]

    def _texture(self, image: Texture, sampling: Sampling, *, srgb: bool) -> moderngl.Texture:
        """Return a mipmapped texture, shared by materials of the same sampling and array (kept alive by the scene)."""
        key = (id(image), srgb, sampling)
        if key not in self._textures:
            height, width = image.shape[:2]
            if image.shape[2] == 3:
                # Four channels: three-channel formats are slower and not renderable for mipmaps.
                image = np.concatenate([image, np.full((height, width, 1), 255, np.uint8)], axis=2)
            data = np.ascontiguousarray(image).tobytes()
            texture = self._ctx.texture((width, height), 4, data, internal_format=_SRGB8_ALPHA8 if srgb else None)
            texture.build_mipmaps()
            texture.filter = (sampling.minify, sampling.magnify)
            texture.repeat_x, texture.repeat_y = sampling.repeat
            self._textures[key] = texture
        return self._textures[key]


def _block(materials: Sequence[Material]) -> bytes:
    block = np.zeros((max(len(materials), 1), _UNIFORM_ALIGNMENT // 4), dtype=np.float32)
    for row, m in zip(block, materials):
        cutoff = 0.5 if m.alpha == "blend" else m.alpha_cutoff
        row[: _BLOCK_BYTES // 4] = [
            *(*m.base_color, float(m.colored_emission)),
            *(*m.emission, float(m.double_sided)),
            *(m.roughness, m.metallic, cutoff, float(m.interface)),
        ]
    return block.tobytes()
