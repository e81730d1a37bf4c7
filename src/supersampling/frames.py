"""Every buffer's name, shape, unit and range, once, and the frame that carries them to a model.

Image plane: x right, y down, origin at the top-left corner; pixel ``(i, j)`` has its centre at ``(j + 0.5, i + 0.5)``.
``h w`` is the low (rendered) resolution, ``H W = scale * h, scale * w`` the high (target) resolution.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from torch import Tensor


@dataclass(frozen=True)
class Buffer:
    """What one buffer holds.

    ``resolution`` is ``low`` (``h w``), ``high`` (``H W``) or ``frame`` (one vector a frame, no image axes).
    ``dtype`` is how a data set stores it; a loader always delivers float32 in ``range``.
    """

    name: str
    channels: int
    resolution: Literal["low", "high", "frame"]
    dtype: str
    unit: str
    range: str


BUFFERS: dict[str, Buffer] = {
    b.name: b
    for b in (
        Buffer("color", 3, "low", "uint8", "display-referred sRGB, one sample a pixel at centre + jitter", "[0, 1]"),
        Buffer("depth", 1, "low", "float32", "linear view depth, 0 at the near plane, 1 at the far plane; sky is 1", "[0, 1]"),
        Buffer(
            "motion", 2, "low", "float32",
            "backward, unjittered (x, y), in units of the whole stored image: previous_uv = uv + motion", "unbounded",
        ),
        Buffer("jitter", 2, "frame", "float32", "(x, y) from the pixel centre, low-resolution pixels", "[-0.5, 0.5)"),
        Buffer("target", 3, "high", "uint8", "display-referred sRGB, supersampled, box-filtered", "[0, 1]"),
    )
}  # fmt: skip


@dataclass(frozen=True)
class Frame:
    """One time step's inputs, float32, batch first; a buffer that nobody asked for is ``None``.

    ``color (B, 3, h, w)``, ``depth (B, 1, h, w)``, ``motion (B, 2, h, w)``, ``jitter (B, 2)``: see `BUFFERS`.
    """

    color: Tensor
    depth: Tensor | None = None
    motion: Tensor | None = None
    jitter: Tensor | None = None

    @classmethod
    def of(cls, clip: Mapping[str, Tensor], t: int) -> "Frame":
        """Time step ``t`` of a clip, whose buffers are ``(B, T, ...)``."""
        names = ("color", "depth", "motion", "jitter")
        return cls(**{name: clip[name][:, t] for name in names if name in clip})
