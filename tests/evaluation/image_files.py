"""PNG files of any depth and number of channels, byte by byte after the format's specification."""

import struct
import zlib
from pathlib import Path

import numpy as np


def write_png(path: Path, image: np.ndarray) -> None:
    """``(h, w, 1, 3 or 4)`` of uint8 or uint16, no filter."""
    height, width, channels = image.shape
    kind = {1: 0, 3: 2, 4: 6}[channels]
    big = image.astype(image.dtype.newbyteorder(">"))
    rows = b"".join(b"\0" + big[y].tobytes() for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8 * image.dtype.itemsize, kind, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
