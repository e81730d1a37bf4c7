"""Images of a glTF file: PNG and JPEG as in the specification, decoded by Pillow within limits."""

import io
import warnings
from functools import cache

import numpy as np
from PIL import Image

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.scene import Texture

LARGEST_SIDE = 16384  # pixels; larger images are an error
USED_SIDE = 4096  # pixels; larger images are halved until they fit


class Images:
    """Images decoded on first use, once with and once without alpha, so that materials share their arrays.

    Raises:
        UserError: A file is missing, is neither PNG nor JPEG, is damaged, or is too large.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self.rgba, self.rgb = cache(self._read_rgba), cache(self._read_rgb)
        self.encoded = self._bytes

    def _read_rgba(self, index: int) -> Texture:
        """Return ``(H, W, 4)`` uint8, as stored."""
        return _decode(self._bytes(index), f"image {index} of {self._document.name}")

    def _read_rgb(self, index: int) -> Texture:
        """Return ``(H, W, 3)`` uint8, as stored."""
        return np.ascontiguousarray(self._read_rgba(index)[..., :3])

    def _bytes(self, index: int) -> bytes:
        image = self._document.item("images", index)
        if image.uri is not None:
            return self._document.resource(image.uri, f"image {index}")
        if image.bufferView is None:
            raise UserError(
                f"Image {index} of {self._document.name} has neither a uri nor a buffer view: export it again."
            )
        return bytes(self._document.view(image.bufferView)[0])


def _decode(data: bytes, what: str) -> Texture:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image: Image.Image = Image.open(io.BytesIO(data), formats=("PNG", "JPEG"))
        if max(image.size) > LARGEST_SIDE:
            raise _too_large(what, f"{image.width}x{image.height} pixels")
        image.load()
    except Image.DecompressionBombError as error:  # Pillow's limit on the area, checked before decoding
        raise _too_large(what, str(error).partition(",")[0]) from error
    except Image.UnidentifiedImageError as error:
        raise UserError(f"The {what} is neither PNG nor JPEG: convert it to one of them.") from error
    except (OSError, SyntaxError, ValueError) as error:
        raise UserError(f"The {what} is damaged ({error}): export it again.") from error
    while max(image.size) > USED_SIDE:
        image = image.reduce(2)
    return _eight_bit(image)


def _too_large(what: str, size: str) -> UserError:
    return UserError(f"The {what} is too large ({size}): shrink it to at most {LARGEST_SIDE} pixels per side.")


def _eight_bit(image: Image.Image) -> Texture:
    if image.mode.startswith("I"):  # 16-bit grey, which Pillow would clip
        grey = np.asarray(image).astype(np.int64) // 257
        return np.ascontiguousarray(np.dstack([grey, grey, grey, np.full_like(grey, 255)]).astype(np.uint8))
    return np.asarray(image.convert("RGBA"))
