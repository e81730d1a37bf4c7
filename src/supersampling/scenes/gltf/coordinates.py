"""Texture coordinates of a texture and their transform (KHR_texture_transform)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

_REPEAT = 10497


@dataclass(frozen=True)
class Coordinates:
    """Transform ``uv' = offset + rotation(scale * uv)`` of ``TEXCOORD_<number>``; ``repeats`` is for wrapping."""

    number: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    repeats: bool = True

    def apply(self, uv: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return transformed ``uv (N, 2)``.

        Rotation is counter-clockwise with v down, as in the extension's example, which reads the lower left quadrant.
        """
        if (self.offset, self.rotation, self.scale) == ((0.0, 0.0), 0.0, (1.0, 1.0)):
            return uv
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        matrix = np.array([[c, s], [-s, c]]) * np.array(self.scale)
        return (uv @ matrix.T + np.array(self.offset)).astype(np.float32)


def coordinates(info: Any, sampler: Any) -> Coordinates:
    """Return the coordinates of a textureInfo and its texture's sampler (None without one)."""
    transform = (info.extensions or {}).get("KHR_texture_transform", {})
    wraps = (_REPEAT,) if sampler is None else (sampler.wrapS or _REPEAT, sampler.wrapT or _REPEAT)
    u, v = transform.get("offset", (0.0, 0.0))
    x, y = transform.get("scale", (1.0, 1.0))
    return Coordinates(
        int(transform.get("texCoord", info.texCoord or 0)),
        (float(u), float(v)),
        float(transform.get("rotation", 0.0)),
        (float(x), float(y)),
        all(wrap == _REPEAT for wrap in wraps),
    )
