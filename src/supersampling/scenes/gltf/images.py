"""Images of a glTF file: PNG and JPEG as in the specification, decoded by Pillow within limits."""

from functools import cache

import numpy as np

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document
from supersampling.scenes.scene import Texture
from supersampling.scenes.textures import decode_rgba, open_texture

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
        return _decode(self._bytes(index), f"The image {index} of {self._document.name}")

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


def _decode(data: bytes, name: str) -> Texture:
    """Return ``(H, W, 4)`` of a file; ``name`` begins each error."""
    image = open_texture(data, name, ("PNG", "JPEG"))
    bands = decode_rgba(image, data, name).split()
    # Band by band: halving RGBA at once would turn the colour of transparent texels black.
    while max(bands[0].size) > USED_SIDE:
        bands = tuple(band.reduce(2) for band in bands)
    return np.stack([np.asarray(band) for band in bands], axis=-1)
