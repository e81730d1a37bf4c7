"""Readers of the PNG and EXR images of captures; every kind of broken file is a `UserError` of one sentence."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import OpenEXR
from numpy.typing import NDArray
from PIL import Image as Pillow
from torchvision.io import ImageReadMode, decode_image, read_file

from supersampling.errors import UserError

MAX_PIXELS = 16 << 20
"""Larger images are an error before they are decoded: 4K has half as many pixels."""

Image = NDArray[np.float32]


def _check_size(path: Path, width: int, height: int, size: tuple[int, int] | None) -> None:
    if not 0 < width * height <= MAX_PIXELS:
        raise UserError(f"{path} has {width}x{height} pixels: use images of at most {MAX_PIXELS} pixels.")
    if size is not None and (width, height) != size:
        raise UserError(
            f"{path} has {width}x{height} pixels: restore the image of {size[0]}x{size[1]} pixels that belongs to the "
            "clip."
        )


def png_size(path: Path) -> tuple[int, int]:
    """Return ``(width, height)`` from the header; errors as in `read_png`."""
    with _open_png(path) as image:
        _check_size(path, *image.size, None)
        return image.size


def read_png(path: Path, size: tuple[int, int], channels: int) -> NDArray[np.uint8]:
    """Return the first ``channels`` of an 8-bit RGB or RGBA image, ``(h, w, channels)``.

    Raises:
        UserError: the file is missing, truncated, not of ``size (width, height)``, or not such an image.
    """
    with _open_png(path) as image:
        _check_size(path, *image.size, size)
        if image.mode not in ("RGB", "RGBA") or len(image.mode) < channels:
            raise UserError(f"{path} is an image of type {image.mode}: export it as 8-bit {'RGBA'[:channels]}.")
        try:
            return np.asarray(image)[..., :channels]
        except (OSError, SyntaxError, ValueError) as error:
            raise UserError(f"{path} is truncated or damaged ({error}): restore it.") from error


def read_display_png(path: Path, size: tuple[int, int]) -> Image:
    """Return an RGB image of 8 or 16 bits per channel, ``(h, w, 3)`` in [0, 1]. An opaque alpha channel is dropped.

    Raises:
        UserError: the file is missing, truncated, not of ``size (width, height)``, not such an image, or not opaque.
    """
    # Raises for files that are not PNG or too large, before they are decoded.
    png_size(path)
    try:
        # Pillow would silently truncate 16 bits to 8.
        values = decode_image(read_file(str(path)), ImageReadMode.UNCHANGED).permute(1, 2, 0).numpy()
    except RuntimeError as error:
        raise UserError(f"{path} is truncated or damaged ({error}): restore it.") from error
    height, width, channels = values.shape
    _check_size(path, width, height, size)
    if channels not in (3, 4):
        raise UserError(f"{path} has {channels} channel{'s' * (channels > 1)}: export it as RGB.")
    highest = np.iinfo(values.dtype).max
    transparent = int((values[..., 3:] < highest).sum())
    if transparent:
        raise UserError(
            f"{path} has {transparent} transparent pixels, whose colour is unknown: export it without alpha."
        )
    return values[..., :3].astype(np.float32) / np.float32(highest)


def _open_png(path: Path) -> Pillow.Image:
    try:
        return Pillow.open(path, formats=("PNG",))
    except FileNotFoundError as error:
        raise UserError(f"{path} is missing: restore it.") from error
    except (OSError, SyntaxError, ValueError, Pillow.DecompressionBombError) as error:
        raise UserError(f"{path} is not a readable PNG image ({error}): restore it.") from error


def exr_size(path: Path) -> tuple[int, int]:
    """Return ``(width, height)`` from the header; errors as in `read_exr`."""
    first, last = _open_exr(path, header_only=True).header()["dataWindow"]
    width, height = (int(n) for n in np.asarray(last, np.int64) - np.asarray(first, np.int64) + 1)
    _check_size(path, width, height, None)
    return width, height


def read_exr(path: Path, size: tuple[int, int], choices: Sequence[str], infinite: bool = False) -> Image:
    """Return channels of an EXR image, ``(h, w, len(choice))``.

    ``choices`` are sets of channel names such as ``("RG", "XY")``, of which the first in the file is read; ``infinite``
    permits infinity, which some renderers write as the depth of the sky.

    Raises:
        UserError: the file is missing, truncated, not of ``size (width, height)``, or without the channels, or has NaN
        or, unless permitted, Inf.
    """
    if exr_size(path) != size:
        _check_size(path, *exr_size(path), size)
    file = _open_exr(path, header_only=False)
    try:
        # The name of a layer may precede that of the channel: "ViewLayer.R".
        planes = {name.rsplit(".", 1)[-1]: channel.pixels for name, channel in file.channels().items()}
    except (ValueError, RuntimeError) as error:
        raise UserError(f"{path} is truncated or damaged ({error}): restore it.") from error
    for choice in choices:
        if set(choice) <= planes.keys():
            image = np.stack([planes[name] for name in choice], axis=-1).astype(np.float32)
            break
    else:
        raise UserError(f"{path} has the channels {', '.join(sorted(planes))}: export {' or '.join(choices)}.")
    broken = int((np.isnan(image) if infinite else ~np.isfinite(image)).sum())
    if broken:
        raise UserError(f"{path} has {broken} values that are NaN or Inf: export this frame again.")
    return image


def _open_exr(path: Path, header_only: bool) -> OpenEXR.File:
    if not path.is_file():
        raise UserError(f"{path} is missing: restore it.")
    try:
        file = OpenEXR.File(str(path), separate_channels=True, header_only=header_only)
        file.header()
    except (ValueError, RuntimeError, TypeError) as error:
        raise UserError(f"{path} is truncated or not an EXR image ({error}): restore it.") from error
    return file
