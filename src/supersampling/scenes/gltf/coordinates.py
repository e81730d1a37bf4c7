"""Texture coordinates of a texture, their transform (KHR_texture_transform), and its sampler."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.scene import Sampling, Texture

_CLAMP, _MIRROR, _REPEAT = 33071, 33648, 10497
_MAGNIFY, _MINIFY = (9728, 9729), (9728, 9729, 9984, 9985, 9986, 9987)  # OpenGL's numbers
_DEFAULT = Sampling()


@dataclass(frozen=True)
class Coordinates:
    """Transform ``uv' = offset + rotation(scale * uv)`` of ``TEXCOORD_<number>``, read if ``textured``."""

    number: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    textured: bool = False

    def apply(self, uv: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return transformed ``uv (N, 2)``.

        Rotation is counter-clockwise with v down, as in the extension's example, which reads the lower left quadrant.
        """
        if (self.offset, self.rotation, self.scale) == ((0.0, 0.0), 0.0, (1.0, 1.0)):
            return uv
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        matrix = np.array([[c, s], [-s, c]]) * np.array(self.scale)
        with np.errstate(over="ignore", invalid="ignore"):
            return (uv @ matrix.T + np.array(self.offset)).astype(np.float32)


def coordinates(info: Any) -> Coordinates:
    """Return the coordinates of a textureInfo."""
    transform = (info.extensions or {}).get("KHR_texture_transform", {})
    u, v = transform.get("offset", (0.0, 0.0))
    x, y = transform.get("scale", (1.0, 1.0))
    return Coordinates(
        int(transform.get("texCoord", info.texCoord or 0)),
        (float(u), float(v)),
        float(transform.get("rotation", 0.0)),
        (float(x), float(y)),
        textured=True,
    )


@dataclass(frozen=True)
class Sampler:
    """Sampling of a texture; ``mirror`` tells for u and v whether every second repetition is mirrored."""

    sampling: Sampling = _DEFAULT
    mirror: tuple[bool, bool] = (False, False)

    def extended(self, image: Texture) -> Texture:
        """Return the image followed by its mirror image, so that repeating both mirrors every second repetition."""
        if self.mirror[0]:
            image = np.concatenate([image, image[:, ::-1]], axis=1)
        return np.concatenate([image, image[::-1]], axis=0) if self.mirror[1] else image

    def apply(self, uv: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the coordinates ``uv (N, 2)`` in the extended image."""
        return uv * np.where(self.mirror, np.float32(0.5), np.float32(1.0)) if any(self.mirror) else uv


def read_sampler(document: Document, index: int | None) -> Sampler:
    """Return a sampler; None is the default: repeating, with linear filters.

    Raises:
        UserError: The sampler does not exist, or has unknown filters or wrapping.
    """
    if index is None:
        return Sampler()
    source = document.item("samplers", index)
    magnify, minify = source.magFilter or _DEFAULT.magnify, source.minFilter or _DEFAULT.minify
    wraps = [_REPEAT if wrap is None else wrap for wrap in (source.wrapS, source.wrapT)]
    for value, known in (
        (magnify, _MAGNIFY),
        (minify, _MINIFY),
        *((wrap, (_CLAMP, _MIRROR, _REPEAT)) for wrap in wraps),
    ):
        if value not in known:
            raise UserError(
                f"Sampler {index} of {document.name} has the unknown filter or wrapping {value}: "
                f"use one of {', '.join(map(str, known))}."
            )
    repeat = (wraps[0] != _CLAMP, wraps[1] != _CLAMP)
    return Sampler(Sampling(minify, magnify, repeat), (wraps[0] == _MIRROR, wraps[1] == _MIRROR))
