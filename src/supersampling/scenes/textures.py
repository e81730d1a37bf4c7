"""Decoding of image files of scenes to 8 bits: rounded rather than cut, and damage is an error."""

import io
import struct
import warnings

from PIL import Image

from supersampling.data.readers.png import PALETTE, Png, is_png, rgba8
from supersampling.errors import UserError

LARGEST_SIDE = 16384  # pixels; larger images are an error


def open_texture(data: bytes, name: str, formats: tuple[str, ...]) -> Image.Image:
    """Return an image whose header is read, without a limit that only warns. ``name`` begins each error.

    Raises:
        UserError: the file is of none of the formats, is damaged, or is too large to be decoded.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(io.BytesIO(data), formats=formats)
    except Image.UnidentifiedImageError as error:
        raise UserError(f"{name} is neither {' nor '.join(formats)}: convert it to one of them.") from error
    except Image.DecompressionBombError as error:  # Pillow's limit on the area
        raise _too_large(name, str(error).partition(",")[0]) from error
    except (OSError, SyntaxError, ValueError, struct.error) as error:
        raise _damaged(name, error) from error
    if max(image.size) > LARGEST_SIDE:
        raise _too_large(name, f"{image.width}x{image.height} pixels")
    return image


def decode_rgba(image: Image.Image, data: bytes, name: str) -> Image.Image:
    """Return an open image as 8-bit RGBA; the colours of transparent pixels are those of the file.

    Raises:
        UserError: the file is damaged; ``name`` begins the message.
    """
    if is_png(data):
        png = Png(data, name)
        if png.color != PALETTE:  # Pillow cuts 16 bits to 8, clips grey, and misses the transparent one of 4 bits
            return Image.fromarray(rgba8(png))
        png.check_pixels()
    try:
        return image.convert("RGBA")
    except (OSError, SyntaxError, ValueError, struct.error) as error:
        raise _damaged(name, error) from error


def _damaged(name: str, error: Exception) -> UserError:
    return UserError(f"{name} is damaged ({error}): restore it.")


def _too_large(name: str, size: str) -> UserError:
    return UserError(f"{name} is too large ({size}): shrink it to at most {LARGEST_SIDE} pixels per side.")
