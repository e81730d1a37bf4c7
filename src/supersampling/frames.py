"""The table of all buffers (name, shape, unit, range) and the frame that carries them to a model.

Image plane: x right, y down, origin at the top-left corner; pixel ``(i, j)`` has its centre at ``(j + 0.5, i + 0.5)``.
``h w`` is the low (rendered) resolution, ``H W = scale * h, scale * w`` the high (target) resolution.

Low-resolution buffers have one sample per pixel, at its centre + jitter. Of the high-resolution ones, ``target`` and
``target_radiance`` are the supersampled reference; ``high_*`` are buffers that a renderer can provide at full
resolution before any light transport (NSRD section 3.1): averages over the target's samples where an average is
meaningful, otherwise (depth, motion, normal, object id) one sample at the pixel's centre.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Literal, overload

import torch
from torch import Tensor

from supersampling.ops.warp import LARGEST, finite_motion

Kind = Literal["display", "light", "reflectance", "plane", "direction", "scalar", "id"]


@dataclass(frozen=True)
class Buffer:
    """Description of one buffer.

    ``resolution`` is ``low`` (``h w``), ``high`` (``H W``) or ``frame`` (one vector per frame, no image axes).
    ``dtype`` is the type in a data set's file; a loader always delivers float32 in ``range``. ``kind`` determines the
    effect of mirroring and of colour changes: ``display`` and ``light`` are colours that a gain scales, ``reflectance``
    is a colour that it does not scale, ``plane`` is a vector in the image plane, and ``direction`` a vector whose first
    two components are in it.
    """

    name: str
    channels: int
    resolution: Literal["low", "high", "frame"]
    dtype: str
    unit: str
    range: str
    kind: Kind = "scalar"


_HALF = "[0, 65504]"
_SHADING = (
    Buffer("radiance", 3, "low", "float16", "linear scene radiance times the scene's exposure", _HALF, "light"),
    Buffer(
        "depth", 1, "low", "float32", "linear view depth, 0 at the near plane, 1 at the far plane; sky is 1", "[0, 1]"
    ),
    Buffer(
        "motion", 2, "low", "float32",
        "backward, unjittered (x, y), in units of the whole stored image: previous_uv = uv + motion", "unbounded",
        "plane",
    ),
    Buffer(
        "normal", 3, "low", "float16",
        "unit shading normal in the camera's axes: x right, y down, z towards the camera; sky is 0", "[-1, 1]",
        "direction",
    ),
    Buffer("albedo", 3, "low", "float16", "linear base colour c; sky is 0", "[0, 1]", "reflectance"),
    Buffer("metallic", 1, "low", "float16", "metallic value m; sky is 0", "[0, 1]"),
    Buffer("roughness", 1, "low", "float16", "perceptual roughness, alpha = roughness^2; sky is 0", "[0, 1]"),
    Buffer(
        "specular", 3, "low", "float16", "reflectance at normal incidence F_0 = lerp(0.04, c, m); sky is 0", "[0, 1]",
        "reflectance",
    ),
    Buffer("n_dot_v", 1, "low", "float16", "cosine between shading normal and view direction; sky is 0", "[0, 1]"),
    Buffer(
        "material", 3, "low", "float16",
        "F_beta, the BRDF's integral over the hemisphere (NSRD supplement, equation 11); sky is 0", "[0, 2]",
        "reflectance",
    ),
    Buffer(
        "emission", 3, "low", "float16",
        "exposed radiance that passes beside demodulation: emitted light, interface elements, the sky", _HALF, "light",
    ),
    Buffer("object_id", 1, "low", "uint16", "number of the scene's object, from 1; sky is 0", "[0, 65535]", "id"),
)  # fmt: skip


def _high(b: Buffer) -> Buffer:
    return Buffer(f"high_{b.name}", b.channels, "high", b.dtype, b.unit, b.range, b.kind)


BUFFERS: dict[str, Buffer] = {
    b.name: b
    for b in (
        Buffer(
            "color", 3, "low", "uint8", "display-referred sRGB, one sample a pixel at centre + jitter", "[0, 1]",
            "display",
        ),
        *_SHADING,
        Buffer(
            "motion_dual", 2, "low", "float32",
            "dual motion vector (NSRD supplement, section 2), as motion; the two are equal where nothing was occluded",
            "unbounded", "plane",
        ),
        Buffer(
            "jitter", 2, "frame", "float32", "(x, y) from the pixel centre, low-resolution pixels", "[-0.5, 0.5)",
            "plane",
        ),
        Buffer("target", 3, "high", "uint8", "display-referred sRGB, supersampled, box-filtered", "[0, 1]", "display"),
        Buffer("target_radiance", 3, "high", "float16", "as radiance, supersampled, box-filtered", _HALF, "light"),
        *(_high(b) for b in _SHADING if b.name != "radiance"),
    )
}  # fmt: skip


def clip_length(clip: Mapping[str, Tensor]) -> int:
    """Return the number of frames of a clip ``(B, T, ...)``; high-resolution buffers may cover the last frames only."""
    return max(values.shape[1] for values in clip.values())


def _repair(name: str, values: Tensor) -> Tensor:
    """Replace values that are not finite: NaN becomes black, far depth or motion from outside; +inf becomes white."""
    if name in ("motion", "motion_dual"):
        return finite_motion(values)
    if name == "depth":
        return torch.nan_to_num(values, 1.0, 1.0, 0.0)
    if name == "color":
        return torch.nan_to_num(values, 0.0, 1.0, 0.0)
    return torch.nan_to_num(values, 0.0, LARGEST, -LARGEST)


@dataclass(frozen=True)
class Frame:
    """Inputs of one time step, float32, batch first; a buffer that was not requested is ``None``.

    Fields are named as in `BUFFERS`: low-resolution ones are ``(B, C, h, w)``, ``jitter`` ``(B, 2)``, ``high_*``
    ``(B, C, H, W)``. References (``target``, ``target_radiance``) are never among a model's inputs.
    """

    color: Tensor | None = None
    radiance: Tensor | None = None
    depth: Tensor | None = None
    motion: Tensor | None = None
    motion_dual: Tensor | None = None
    jitter: Tensor | None = None
    normal: Tensor | None = None
    albedo: Tensor | None = None
    metallic: Tensor | None = None
    roughness: Tensor | None = None
    specular: Tensor | None = None
    n_dot_v: Tensor | None = None
    material: Tensor | None = None
    emission: Tensor | None = None
    object_id: Tensor | None = None
    high_depth: Tensor | None = None
    high_motion: Tensor | None = None
    high_normal: Tensor | None = None
    high_albedo: Tensor | None = None
    high_metallic: Tensor | None = None
    high_roughness: Tensor | None = None
    high_specular: Tensor | None = None
    high_n_dot_v: Tensor | None = None
    high_material: Tensor | None = None
    high_emission: Tensor | None = None
    high_object_id: Tensor | None = None

    @classmethod
    def from_clip(cls, clip: Mapping[str, Tensor], t: int) -> "Frame":
        """Return time step ``t`` of a clip ``(B, T, ...)``; a buffer that begins after ``t`` is ``None``."""
        length = clip_length(clip)
        indices = {f.name: t - (length - clip[f.name].shape[1]) for f in fields(cls) if f.name in clip}
        return cls(**{name: clip[name][:, k] for name, k in indices.items() if k >= 0})

    @overload
    def need(self, name: str, /) -> Tensor: ...

    @overload
    def need(self, first: str, second: str, /, *rest: str) -> tuple[Tensor, ...]: ...

    def need(self, *names: str) -> Tensor | tuple[Tensor, ...]:
        """Return the named buffers in order, or the tensor itself for a single name.

        Raises:
            ValueError: buffers are missing, which `requires` of the model that reads them should have prevented.
        """
        buffers = [getattr(self, name) for name in names]
        missing = [name for name, values in zip(names, buffers) if values is None]
        if missing:
            raise ValueError(f"The frame has no {', '.join(missing)}: add the missing buffers to the model's requires.")
        return buffers[0] if len(buffers) == 1 else tuple(buffers)

    def repair(self) -> "Frame":
        """Return a copy whose low-resolution buffers and jitter are finite; values that were finite keep every bit.

        A renderer's NaN would otherwise spread through a network and stay in the state that is passed from frame to
        frame. ``high_*`` buffers are left as they are: models read them only to present an output, where nothing
        spreads.
        """
        buffers = ((f.name, getattr(self, f.name)) for f in fields(self) if not f.name.startswith("high_"))
        return replace(self, **{name: _repair(name, values) for name, values in buffers if values is not None})
