"""PNG images (W3C PNG, third edition): checked chunk by chunk, then decoded by libpng.

libpng's callers may crash on compressed data that end early, and Pillow does not compare the checksums of pixels and
cuts 16 bits to 8. A file that passes these checks is decoded exactly.
"""

import struct
import zlib
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torchvision.io import ImageReadMode, decode_image

from supersampling.errors import UserError

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: ("grey", 1), 2: ("RGB", 3), 3: ("palette", 1), 4: ("grey with alpha", 2), 6: ("RGBA", 4)}
"""Name and number of channels of each colour type."""
PALETTE = 3
DEPTHS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and the steps between columns and rows, of the passes of an interlaced image."""
CRITICAL = (b"IHDR", b"PLTE", b"IDAT", b"IEND")


def is_png(data: bytes) -> bool:
    return data.startswith(SIGNATURE)


class Png:
    """The header and the chunks of a PNG file; pixels are decoded on request.

    Args:
        data: the file.
        name: the beginning of each error: the path, or what the image belongs to.

    Raises:
        UserError: the file is not PNG, is damaged, or has a chunk that is necessary and unknown.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self.name, self._data = name, data
        if not is_png(data):
            raise UserError(f"{name} is not a readable PNG image: restore it.")
        self.chunks: dict[bytes, bytes] = {}
        """The content of the first chunk of each kind."""
        self._compressed: list[bytes] = []
        self._read_chunks()
        header = self.chunks.get(b"IHDR", b"")
        if len(header) != 13:
            raise self._damaged("its header is incomplete")
        self.width, self.height, self.depth, self.color, *_, self._interlace = struct.unpack(">IIBBBBB", header)
        methods = header[10:12]
        known = self.depth in DEPTHS.get(self.color, ()) and methods == b"\0\0" and self._interlace in (0, 1)
        if not known or min(self.width, self.height) < 1 or (self.color == PALETTE and b"PLTE" not in self.chunks):
            raise self._damaged("its header is invalid")

    @property
    def size(self) -> tuple[int, int]:
        return self.width, self.height

    @property
    def type(self) -> str:
        """The name of the type, such as ``8-bit RGB`` or ``16-bit grey with transparency``."""
        alpha = " with transparency" if b"tRNS" in self.chunks else ""
        return f"{self.depth}-bit {CHANNELS[self.color][0]}{alpha}"

    def pixels(self) -> NDArray[Any]:
        """Return ``(h, w, C)`` uint8 or uint16 of an image without palette.

        Values of fewer than 8 bits are scaled to 8; ``tRNS`` is not applied.
        """
        self.check_pixels()
        data = torch.frombuffer(bytearray(self._plain()), dtype=torch.uint8)
        return decode_image(data, ImageReadMode.UNCHANGED).permute(1, 2, 0).numpy()

    def check_pixels(self) -> None:
        """Raise `UserError` unless the compressed data hold the image, no less and no more."""
        bits = self.depth * CHANNELS[self.color][1]
        rows = [(1 + (bits * width + 7) // 8, height) for width, height in self._passes()]
        length = sum(row * count for row, count in rows)
        stream = zlib.decompressobj()
        try:
            lines = stream.decompress(b"".join(self._compressed), length + 1)
        except zlib.error as error:
            raise self._damaged(str(error)) from error
        if len(lines) != length or not stream.eof:
            raise self._damaged(f"it has {len(lines)} of {length} bytes of pixels")
        start = 0
        for row, count in rows:
            filters = np.frombuffer(lines, np.uint8, row * count, start)[::row]
            start += row * count
            if (filters > 4).any():
                raise self._damaged("a row has an unknown filter")

    def _passes(self) -> list[tuple[int, int]]:
        """Return the width and height of each pass that has pixels."""
        if not self._interlace:
            return [self.size]
        sizes = [(-(-(self.width - x) // dx), -(-(self.height - y) // dy)) for x, y, dx, dy in PASSES]
        return [(width, height) for width, height in sizes if width > 0 and height > 0]

    def _plain(self) -> bytes:
        """Return the file with the necessary chunks only, so that no other one changes how libpng decodes."""
        return SIGNATURE + b"".join(
            _chunk(kind, content)
            for kind, content in (
                (b"IHDR", self.chunks[b"IHDR"]),
                (b"IDAT", b"".join(self._compressed)),
                (b"IEND", b""),
            )
        )

    def _read_chunks(self) -> None:
        place, kind = len(SIGNATURE), b""
        while kind != b"IEND":
            length, kind = struct.unpack(">I4s", self._data[place : place + 8].ljust(8, b"\0"))
            end = place + 12 + length
            if end > len(self._data):
                raise self._damaged("it ends early")
            content = self._data[place + 8 : end - 4]
            if struct.pack(">I", zlib.crc32(kind + content)) != self._data[end - 4 : end]:
                raise self._damaged(f"the checksum at byte {place} is wrong")
            if not kind[0] & 0x20 and kind not in CRITICAL:
                raise UserError(f"{self.name} has the unknown chunk {kind.decode('latin-1')}: export an ordinary PNG.")
            self.chunks.setdefault(kind, content)
            if kind == b"IDAT":
                self._compressed.append(content)
            place = end

    def _damaged(self, reason: str) -> UserError:
        return UserError(f"{self.name} is truncated or damaged ({reason}): restore it.")


def rgba8(png: Png) -> NDArray[np.uint8]:
    """Return ``(h, w, 4)`` of an image that is not a palette's, rounded to 8 bits, with ``tRNS`` as alpha."""
    values, highest = png.pixels(), 255 if png.depth <= 8 else 65535
    grey = values.shape[-1] < 3
    colors = values[..., :1].repeat(3, axis=-1) if grey else values[..., :3]
    alpha = values[..., -1:] if values.shape[-1] in (2, 4) else np.full_like(colors[..., :1], highest)
    if b"tRNS" in png.chunks and values.shape[-1] in (1, 3):
        scale = highest // ((1 << png.depth) - 1)
        key = np.frombuffer(png.chunks[b"tRNS"], ">u2")[: values.shape[-1]].astype(np.int64) * scale
        alpha = np.where((values == key).all(axis=-1, keepdims=True), 0, highest)
    whole = np.concatenate([colors, alpha], axis=-1)
    if highest == 255:
        return whole.astype(np.uint8)
    return ((whole.astype(np.uint32) + 128) // 257).astype(np.uint8)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
