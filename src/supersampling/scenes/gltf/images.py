"""Images of a glTF file: PNG and JPEG, as the specification allows, decoded by Pillow within limits."""

import io
import warnings
from functools import cache

import numpy as np
from PIL import Image

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.scene import Texture

LARGEST_SIDE = 16384  # pixels; larger ones are refused
KEPT_SIDE = 4096  # pixels; larger ones are halved until they fit


class Images:
    """Decodes each image once with alpha and once without, as far as asked for, so that materials share its array.

    Raises:
        UserError: a missing file, one that is neither PNG nor JPEG, or damaged, or too large.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self.rgba, self.rgb = cache(self._rgba), cache(self._rgb)

    def _rgba(self, index: int) -> Texture:
        """``(H, W, 4)`` uint8, as stored."""
        return _decoded(self._bytes(index), f"image {index} of {self._document.name}")

    def _rgb(self, index: int) -> Texture:
        """``(H, W, 3)`` uint8, as stored."""
        return np.ascontiguousarray(self._rgba(index)[..., :3])

    def _bytes(self, index: int) -> bytes:
        image = self._document.item("images", index)
        if image.uri is not None:
            return self._document.resource(image.uri, f"image {index}")
        if image.bufferView is None:
            raise UserError(
                f"Image {index} of {self._document.name} has neither a uri nor a buffer view: export it again."
            )
        return bytes(self._document.view(image.bufferView)[0])


def _decoded(data: bytes, what: str) -> Texture:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image: Image.Image = Image.open(io.BytesIO(data), formats=("PNG", "JPEG"))
        if max(image.size) > LARGEST_SIDE:
            raise _too_large(what, f"{image.width}x{image.height} pixels")
        image.load()
    except Image.DecompressionBombError as error:  # Pillow's limit on the area, told before anything is decoded
        raise _too_large(what, str(error).partition(",")[0]) from error
    except Image.UnidentifiedImageError as error:
        raise UserError(f"The {what} is neither PNG nor JPEG: convert it to one of them.") from error
    except (OSError, SyntaxError, ValueError) as error:
        raise UserError(f"The {what} is damaged ({error}): export it again.") from error
    while max(image.size) > KEPT_SIDE:
        image = image.reduce(2)
    return _eight_bit(image)


def _too_large(what: str, size: str) -> UserError:
    return UserError(f"The {what} is too large ({size}): shrink it to {LARGEST_SIDE} pixels a side or less.")


def _eight_bit(image: Image.Image) -> Texture:
    if image.mode.startswith("I"):  # 16-bit grey, which Pillow would clip
        grey = np.asarray(image).astype(np.int64) // 257
        return np.ascontiguousarray(np.dstack([grey, grey, grey, np.full_like(grey, 255)]).astype(np.uint8))
    return np.asarray(image.convert("RGBA"))
