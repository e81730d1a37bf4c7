"""Reader of EXR images: the channels that are meant, at their place in the image, or one sentence why that is unclear.

The image is the file's display window. Of several layers in one part, the layer without a name is the image.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from supersampling.data.readers.exr_file import ExrPart, read_channels, read_parts
from supersampling.data.readers.images import Image, check_size
from supersampling.errors import UserError

COLORS = ("RGB",)
ALPHA = "A"
OPAQUE = 1.0 - 2.0**-11
"""Alpha from which on a pixel is opaque: a renderer's sum of weights, rounded to half floats, may fall short of 1."""
REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
"""Chromaticities of red, green, blue and white, which also hold for files that state none."""
REC_709_NAMES = ("lin_rec709_scene", "lin_rec709_display", "data", "unknown", "")


class Layer(NamedTuple):
    """The channels of a part whose names share the text before the last dot."""

    part: int
    prefix: str
    """``ViewLayer.Combined.``, or nothing for the layer without a name."""
    choice: str
    """The channels to be read, such as ``RGB``."""


def exr_size(path: Path, choices: Sequence[str] = COLORS) -> tuple[int, int]:
    """Return ``(width, height)`` from the header; errors as in `read_exr`."""
    return ExrImage(path, choices).size


def read_exr(path: Path, size: tuple[int, int], choices: Sequence[str], infinite: bool = False) -> Image:
    """Return channels of an EXR image, ``(h, w, len(choice))``.

    ``choices`` are sets of channel names such as ``("RG", "XY")``, of which the file must have one; ``infinite``
    permits infinity, which some renderers write as the depth of the sky.

    Raises:
        UserError: the file is missing, damaged, deep, not of ``size (width, height)``, or without the channels; several
            layers or parts have them; they do not cover the image, are stored at a lower resolution, or have NaN, Inf
            (unless permitted) or integers that 32-bit floats do not represent.
    """
    image = ExrImage(path, choices)
    return image.read(image.layer.choice, size, infinite)


def read_exr_colors(path: Path, size: tuple[int, int]) -> Image:
    """Return linear Rec. 709 colours ``(h, w, 3)``; alpha is not read. Errors as in `read_exr`, and other primaries."""
    image = ExrImage(path, COLORS)
    image.check_primaries()
    return image.read("RGB", size)


def read_opaque_exr(path: Path, size: tuple[int, int]) -> Image:
    """Return linear Rec. 709 colours ``(h, w, 3)``. Errors as in `read_exr_colors`, and transparent pixels."""
    image = ExrImage(path, COLORS)
    image.check_primaries()
    if not image.has(ALPHA):
        return image.read("RGB", size)
    values = image.read(f"RGB{ALPHA}", size)
    transparent = int((values[..., 3] < OPAQUE).sum())
    if transparent:
        raise UserError(
            f"{path} has {transparent} transparent pixels, whose colour is unknown: export it without alpha."
        )
    return values[..., :3]


class ExrImage:
    """The layer of a file that has one of the choices; pixels are read on request. Errors: see `read_exr`."""

    def __init__(self, path: Path, choices: Sequence[str]) -> None:
        self.path = path
        parts = read_parts(path)
        for part in parts:
            check_size(path, *part.data.size, None)
            check_size(path, *part.display.size, None)
        self.layer = _select(path, parts, choices)
        self._part = parts[self.layer.part]
        self._check_coverage()

    @property
    def size(self) -> tuple[int, int]:
        """The width and height of the display window."""
        return self._part.display.size

    def has(self, name: str) -> bool:
        """Return whether the layer has a channel."""
        return self.layer.prefix + name in self._part.sampling

    def read(self, names: str, size: tuple[int, int], infinite: bool = False) -> Image:
        """Return channels of the layer, ``(h, w, C)``, of an image of this size."""
        check_size(self.path, *self.size, size)
        (width, height), data, display = size, self._part.data, self._part.display
        left, top = display.left - data.left, display.top - data.top
        image = np.empty((height, width, len(names)), dtype=np.float32)
        channels = read_channels(self.path, self.layer.part, [self.layer.prefix + name for name in names])
        for k, stored in enumerate(channels):
            plane = stored[top : top + height, left : left + width]
            image[..., k] = plane
            if plane.dtype.kind == "u" and (image[..., k].astype(np.float64) != plane).any():
                raise UserError(f"{self.path} has integers above {1 << 24} in {names[k]}: export 32-bit floats.")
        broken = int((np.isnan(image) if infinite else ~np.isfinite(image)).sum())
        if broken:
            raise UserError(f"{self.path} has {broken} values that are NaN or Inf: export this frame again.")
        return image

    def check_primaries(self) -> None:
        """Raise `UserError` if the file states that its colours are not linear Rec. 709."""
        name = self._part.attributes.get("colorInteropID", "")
        if name not in REC_709_NAMES:
            raise UserError(f"{self.path} has colours of the space {name}: export linear Rec. 709.")
        stated = self._part.attributes.get("chromaticities", REC_709)
        if not np.allclose(stated, REC_709, rtol=0.0, atol=2e-3):
            pairs = ", ".join(f"{x:.4g} {y:.4g}" for x, y in np.reshape(stated, (-1, 2)))
            raise UserError(f"{self.path} has other primaries than Rec. 709 ({pairs}): export linear Rec. 709.")

    def _check_coverage(self) -> None:
        coarse = [name for name in _names(self._part, self.layer.prefix) if self._part.sampling[name] != (1, 1)]
        if coarse:
            raise UserError(
                f"{self.path} has channels of a lower resolution ({', '.join(coarse)}): export "
                f"{', '.join(self.layer.choice)} for every pixel."
            )
        if not self._part.data.covers(self._part.display):
            raise UserError(
                f"{self.path} has the pixels {self._part.data} (data window) of an image of the pixels "
                f"{self._part.display} (display window): export the whole image."
            )


def _select(path: Path, parts: Sequence[ExrPart], choices: Sequence[str]) -> Layer:
    """Return the layer that has one of the choices: the only one, or of one part's the layer without a name."""
    layers = [
        Layer(number, prefix, choice)
        for number, part in enumerate(parts)
        for prefix in dict.fromkeys(map(_prefix, part.sampling))
        for choice in choices
        if all(prefix + name in part.sampling for name in choice)
    ]
    if not layers:
        present = ", ".join(sorted({name for part in parts for name in part.sampling}))
        raise UserError(f"{path} has the channels {present}: export {' or '.join(choices)}.")
    if len({layer.part for layer in layers}) > 1:
        raise _ambiguous(path, layers, "parts", [parts[n].name or f"number {n}" for n, *_ in layers])
    layers = [layer for layer in layers if not layer.prefix] or layers
    if len({layer.prefix for layer in layers}) > 1:
        raise _ambiguous(path, layers, "layers", [layer.prefix.removesuffix(".") for layer in layers])
    if len(layers) > 1:
        present = " and ".join(", ".join(layer.choice) for layer in layers)
        raise UserError(f"{path} has {present}, and which of them is meant is unknown: export only one of them.")
    if parts[layers[0].part].deep:
        raise UserError(f"{path} is a deep image, with several samples for each pixel: export a flat image.")
    return layers[0]


def _ambiguous(path: Path, layers: Sequence[Layer], kind: str, names: Iterable[str]) -> UserError:
    channels = " or ".join(dict.fromkeys(", ".join(layer.choice) for layer in layers))
    return UserError(
        f"{path} has {channels} in several {kind} ({', '.join(dict.fromkeys(names))}): export only the one that is "
        "meant."
    )


def _prefix(channel: str) -> str:
    """Return the name of a channel's layer and the dot behind it."""
    layer, dot, _ = channel.rpartition(".")
    return layer + dot


def _names(part: ExrPart, prefix: str) -> list[str]:
    return sorted(name for name in part.sampling if _prefix(name) == prefix)
