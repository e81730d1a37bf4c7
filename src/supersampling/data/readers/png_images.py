"""Readers of PNG images of captures and of frames: display colours exactly as they are stored, or one sentence why not.

Values are sRGB. A file that states another colour space, a rotation or several frames is an error.
"""

import io
import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from PIL import ImageCms

from supersampling.data.readers.images import Image, check_readable, check_size
from supersampling.data.readers.png import CHANNELS, Png, is_png
from supersampling.errors import UserError

SRGB_GAMMA = 45455
"""1/2.2 in units of 1e-5, as writers of sRGB state it."""
SRGB_PRIMARIES = (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
"""White, red, green and blue of sRGB in units of 1e-5."""
SRGB_CODE = b"\1\x0d\0\1"
"""Primaries, transfer function, matrix and range of full-range sRGB (ITU-T H.273)."""
TOLERANCE = 0.02  # relative to 1/2.2 and absolute in chromaticities
ORIENTATION = 0x0112
MAX_PROFILE = 16 << 20  # bytes


def png_size(path: Path) -> tuple[int, int]:
    """Return ``(width, height)`` from the header; errors as in `read_png_colors`."""
    png = _open(path)
    check_size(path, *png.size, None)
    return png.size


def read_png(path: Path, size: tuple[int, int], channels: int) -> NDArray[np.uint8]:
    """Return the first ``channels`` of an 8-bit RGB or RGBA image as stored, ``(h, w, channels)``.

    Raises:
        UserError: the file is missing, damaged, not of ``size (width, height)``, or not such an image.
    """
    png = _open(path)
    check_size(path, *png.size, size)
    if png.depth != 8 or png.color not in (2, 6) or CHANNELS[png.color][1] < channels:
        raise UserError(f"{path} is an image of type {png.type}: export it as 8-bit {'RGBA'[:channels]}.")
    return png.pixels()[..., :channels]


def read_png_colors(path: Path, size: tuple[int, int]) -> Image:
    """Return the colours of an RGB or RGBA image of 8 or 16 bits, ``(h, w, 3)`` in [0, 1]; alpha is not read.

    Raises:
        UserError: the file is missing, damaged, not of ``size (width, height)``, not such an image, or not sRGB.
    """
    return _color_image(path, size)[..., :3]


def read_display_png(path: Path, size: tuple[int, int]) -> Image:
    """Return what `read_png_colors` returns of an opaque image.

    Raises:
        UserError: as there, or a pixel is transparent.
    """
    image = _color_image(path, size)
    transparent = int((image[..., 3:] < 1.0).sum())
    if transparent:
        raise UserError(
            f"{path} has {transparent} transparent pixels, whose colour is unknown: export it without alpha."
        )
    return image[..., :3]


def _color_image(path: Path, size: tuple[int, int]) -> Image:
    """Return ``(h, w, 3 or 4)`` in [0, 1]."""
    png = _open(path)
    check_size(path, *png.size, size)
    if png.color not in (2, 6):
        raise UserError(f"{path} is an image of type {png.type}: export it as RGB.")
    if b"tRNS" in png.chunks:
        raise UserError(f"{path} has a transparent colour (chunk tRNS): export it without transparency.")
    _check_display(png)
    values = png.pixels()
    return values.astype(np.float32) / np.float32(np.iinfo(values.dtype).max)


def _open(path: Path) -> Png:
    check_readable(path)
    data = path.read_bytes()
    if not is_png(data):
        raise UserError(f"{path} is not a readable PNG image (its content is {_format(data)}): export it as PNG.")
    return Png(data, str(path))


def _format(data: bytes) -> str:
    try:
        return str(Pillow.open(io.BytesIO(data)).format)
    except (OSError, SyntaxError, ValueError, Pillow.DecompressionBombError):
        return "no known image" if data else "empty"


def _check_display(png: Png) -> None:
    """Raise `UserError` if the file has several frames, is to be turned, or is not sRGB."""
    frames = struct.unpack(">I", png.chunks.get(b"acTL", b"")[:4].rjust(4, b"\0"))[0]
    if frames > 1:
        raise UserError(f"{png.name} is an animation of {frames} frames: export one file for each frame.")
    turn = _orientation(png.chunks.get(b"eXIf", b""))
    if turn != 1:
        raise UserError(f"{png.name} is to be turned or mirrored (Exif orientation {turn}): export it upright.")
    space = _foreign_space(png)
    if space:
        raise UserError(f"{png.name} has colours of {space}: export it as sRGB.")


def _orientation(exif: bytes) -> int:
    tags = Pillow.Exif()
    try:
        tags.load(exif)
        return int(tags.get(ORIENTATION, 1))
    except (OSError, SyntaxError, ValueError, TypeError, struct.error):
        return 1  # damaged metadata turn nothing


def _foreign_space(png: Png) -> str:
    """Return the colour space that the file states, nothing if it states sRGB or none; the first chunk here decides."""
    chunks = png.chunks
    if b"cICP" in chunks:
        return "" if chunks[b"cICP"] == SRGB_CODE else f"the space {'-'.join(map(str, chunks[b'cICP']))} (chunk cICP)"
    if b"iCCP" in chunks:
        name = chunks[b"iCCP"].partition(b"\0")[0].decode("latin-1")
        return "" if _is_srgb(png) else f"the profile {name} (chunk iCCP)"
    if b"sRGB" in chunks:
        return ""
    if b"gAMA" in chunks:
        gamma = int.from_bytes(chunks[b"gAMA"][:4], "big")
        if abs(gamma / SRGB_GAMMA - 1.0) > TOLERANCE:
            return f"gamma {gamma / 1e5:g} (chunk gAMA)"
    if b"cHRM" in chunks:
        stated = np.frombuffer(chunks[b"cHRM"].ljust(32, b"\0")[:32], ">u4")
        if np.abs(stated.astype(np.int64) - SRGB_PRIMARIES).max() > TOLERANCE * 1e5:
            return "other primaries (chunk cHRM)"
    return ""


def _is_srgb(png: Png) -> bool:
    """Return whether a colour profile leaves sRGB values as they are, up to 2 of 255."""
    packed = png.chunks[b"iCCP"].partition(b"\0")[2][1:]
    levels = np.array([0, 32, 64, 96, 128, 192, 255], dtype=np.uint8)
    grid = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(1, -1, 3)
    try:
        profile = ImageCms.ImageCmsProfile(io.BytesIO(zlib.decompressobj().decompress(packed, MAX_PROFILE)))
        converted = ImageCms.profileToProfile(Pillow.fromarray(grid), profile, ImageCms.createProfile("sRGB"))
    except (ImageCms.PyCMSError, OSError, ValueError, zlib.error):
        return False
    return bool(np.abs(np.asarray(converted).astype(int) - grid).max() <= 2)
