"""Reader of EXR images: the channels that are meant, at their place in the image, or one sentence why that is unclear.

The image is the file's display window. Of several layers in one part, the layer without a name is the image.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from supersampling.data.readers.images import Image, check_readable, check_size
from supersampling.errors import UserError

COLORS = ("RGB",)
ALPHA = "A"
OPAQUE = 1.0 - 2.0**-11
"""Alpha from which on a pixel is opaque: a renderer's sum of weights, rounded to half floats, may fall short of 1."""
REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
"""Chromaticities of red, green, blue and white, which also hold for files that state none."""
REC_709_NAMES = ("lin_rec709_scene", "lin_rec709_display", "data", "unknown")
DEEP = (OpenEXR.deepscanline, OpenEXR.deeptile)

Header = dict[str, Any]


class Layer(NamedTuple):
    """The channels of a part whose names share the text before the last dot."""

    part: int
    prefix: str
    """``ViewLayer.Combined.``, or nothing for the layer without a name."""
    choice: str
    """The channels to be read, such as ``RGB``."""


class Window(NamedTuple):
    """The first and the last pixel of a rectangle."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def size(self) -> tuple[int, int]:
        return self.right - self.left + 1, self.bottom - self.top + 1

    def covers(self, window: "Window") -> bool:
        """Return whether each pixel of a window lies in this one."""
        before = self.left <= window.left and self.top <= window.top
        return before and self.right >= window.right and self.bottom >= window.bottom

    def __str__(self) -> str:
        return f"{self.left},{self.top} to {self.right},{self.bottom}"


def exr_size(path: Path, choices: Sequence[str] = COLORS) -> tuple[int, int]:
    """Return ``(width, height)`` from the header; errors as in `read_exr`."""
    return ExrFile(path, choices).size


def read_exr(path: Path, size: tuple[int, int], choices: Sequence[str]) -> Image:
    """Return channels of an EXR image, ``(h, w, len(choice))``.

    ``choices`` are sets of channel names such as ``("RG", "XY")``, of which the file must have one.

    Raises:
        UserError: the file is missing, damaged, deep, not of ``size (width, height)``, or without the channels; several
            layers or parts have them; they do not cover the image, are stored at a lower resolution, or have NaN, Inf
            or integers that 32-bit floats do not represent.
    """
    return ExrFile(path, choices).read(size)


def read_exr_colors(path: Path, size: tuple[int, int]) -> Image:
    """Return linear Rec. 709 colours ``(h, w, 3)``; alpha is not read. Errors as in `read_exr`, and other primaries."""
    file = ExrFile(path, COLORS)
    file.check_primaries()
    return file.read(size)


def read_opaque_exr(path: Path, size: tuple[int, int]) -> Image:
    """Return linear Rec. 709 colours ``(h, w, 3)``. Errors as in `read_exr_colors`, and transparent pixels."""
    file = ExrFile(path, COLORS)
    file.check_primaries()
    file.check_opaque()
    return file.read(size)


class ExrFile:
    """An EXR file whose header is read; pixels are read on request. Errors: see `read_exr`."""

    def __init__(self, path: Path, choices: Sequence[str]) -> None:
        self.path = path
        file = _open(path, header_only=True)
        headers = [file.header(k) for k in range(len(file.parts))]
        for header in headers:
            for window in (_window(header, "dataWindow"), _window(header, "displayWindow")):
                check_size(path, *window.size, None)
        self._layer = _select(path, headers, choices)
        self._header = headers[self._layer.part]
        self._channels = {c.name: c for c in self._header["channels"]}
        self._data, self._display = _window(self._header, "dataWindow"), _window(self._header, "displayWindow")
        self._parts: list[Any] = []
        self._check_coverage()

    @property
    def size(self) -> tuple[int, int]:
        """The width and height of the display window."""
        return self._display.size

    def read(self, size: tuple[int, int]) -> Image:
        """Return the channels ``(h, w, C)`` of an image of this size."""
        check_size(self.path, *self.size, size)
        image = np.stack([self._plane(name) for name in self._layer.choice], axis=-1)
        broken = int((~np.isfinite(image)).sum())
        if broken:
            raise UserError(f"{self.path} has {broken} values that are NaN or Inf: export this frame again.")
        return image

    def check_primaries(self) -> None:
        """Raise `UserError` if the file states that its colours are not linear Rec. 709."""
        name = self._header.get("colorInteropID", REC_709_NAMES[0])
        if name not in REC_709_NAMES:
            raise UserError(f"{self.path} has colours of the space {name}: export linear Rec. 709.")
        stated = self._header.get("chromaticities", REC_709)
        if not np.allclose(stated, REC_709, rtol=0.0, atol=2e-3):
            pairs = ", ".join(f"{x:.4g} {y:.4g}" for x, y in np.reshape(stated, (-1, 2)))
            raise UserError(f"{self.path} has other primaries than Rec. 709 ({pairs}): export linear Rec. 709.")

    def check_opaque(self) -> None:
        """Raise `UserError` if a pixel's alpha is below 1: its colour is only a part of what is seen."""
        if self._layer.prefix + ALPHA in self._channels:
            transparent = int((~(self._plane(ALPHA) >= OPAQUE)).sum())
            if transparent:
                raise UserError(
                    f"{self.path} has {transparent} transparent pixels, whose colour is unknown: export it without "
                    "alpha."
                )

    def _check_coverage(self) -> None:
        names = [n for n in self._channels if n.rpartition(".")[0] == self._layer.prefix.removesuffix(".")]
        coarse = [n for n in names if (self._channels[n].xSampling, self._channels[n].ySampling) != (1, 1)]
        if coarse:
            raise UserError(
                f"{self.path} has channels of a lower resolution ({', '.join(sorted(coarse))}): export "
                f"{', '.join(self._layer.choice)} for every pixel."
            )
        if not self._data.covers(self._display):
            raise UserError(
                f"{self.path} has the pixels {self._data} (data window) of an image of the pixels {self._display} "
                "(display window): export the whole image."
            )

    def _plane(self, name: str) -> Image:
        """Return a channel of the layer, cropped to the display window."""
        if not self._parts:
            self._parts = _open(self.path, header_only=False).parts
        stored = self._parts[self._layer.part].channels[self._layer.prefix + name].pixels
        left, top = self._display.left - self._data.left, self._display.top - self._data.top
        width, height = self._display.size
        plane: NDArray[Any] = stored[top : top + height, left : left + width]
        if plane.dtype.kind == "u" and (plane.astype(np.float32).astype(np.float64) != plane).any():
            raise UserError(f"{self.path} has integers above {1 << 24} in {name}: export 32-bit floats.")
        return plane.astype(np.float32)


def _select(path: Path, headers: Sequence[Header], choices: Sequence[str]) -> Layer:
    """Return the layer that has one of the choices: the only one, or of one part's the layer without a name."""
    layers = [
        Layer(part, prefix, choice)
        for part, header in enumerate(headers)
        for prefix, names in _layers(header).items()
        for choice in choices
        if set(choice) <= names
    ]
    if not layers:
        present = ", ".join(sorted({c.name for header in headers for c in header["channels"]}))
        raise UserError(f"{path} has the channels {present}: export {' or '.join(choices)}.")
    if len({layer.part for layer in layers}) > 1:
        raise _ambiguous(path, layers, "parts", [_part_name(headers, layer) for layer in layers])
    unnamed = [layer for layer in layers if not layer.prefix]
    layers = unnamed or layers
    if len({layer.prefix for layer in layers}) > 1:
        raise _ambiguous(path, layers, "layers", [layer.prefix.removesuffix(".") for layer in layers])
    if len(layers) > 1:
        present = " and ".join(", ".join(layer.choice) for layer in layers)
        raise UserError(f"{path} has {present}, and which of them is meant is unknown: export only one of them.")
    if headers[layers[0].part].get("type") in DEEP:
        raise UserError(f"{path} is a deep image, with several samples for each pixel: export a flat image.")
    return layers[0]


def _ambiguous(path: Path, layers: Sequence[Layer], kind: str, names: Sequence[str]) -> UserError:
    channels = " or ".join(dict.fromkeys(", ".join(layer.choice) for layer in layers))
    return UserError(
        f"{path} has {channels} in several {kind} ({', '.join(dict.fromkeys(names))}): export only the one that is "
        "meant."
    )


def _part_name(headers: Sequence[Header], layer: Layer) -> str:
    return str(headers[layer.part].get("name") or f"number {layer.part}")


def _layers(header: Header) -> dict[str, set[str]]:
    """Return the names of the channels by the prefix of their layer."""
    layers: dict[str, set[str]] = {}
    for channel in header["channels"]:
        layer, dot, name = channel.name.rpartition(".")
        layers.setdefault(layer + dot, set()).add(name)
    return layers


def _window(header: Header, name: str) -> Window:
    first, last = header[name]
    return Window(*(int(n) for n in (*first, *last)))


def _open(path: Path, header_only: bool) -> OpenEXR.File:
    check_readable(path)
    try:
        file = OpenEXR.File(str(path), separate_channels=True, header_only=header_only)
        file.header()
    except (ValueError, RuntimeError, TypeError) as error:
        raise UserError(f"{path} is truncated or not an EXR image ({error}): restore it.") from error
    return file
