"""PNG files of every type, byte by byte after the format's specification, independent of any library."""

import struct
import zlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png_bytes(
    image: np.ndarray,
    *,
    color: int = 2,
    depth: int = 8,
    interlaced: bool = False,
    filters: Iterable[int] = (0,),
    chunks: Iterable[tuple[bytes, bytes]] = (),
) -> bytes:
    """Encode ``(h, w, C)`` integers of ``depth`` bits; row ``y`` of a pass has the filter ``filters[y % n]``."""
    height, width, _ = image.shape
    passes = PASSES if interlaced else ((0, 0, 1, 1),)
    parts = [image[y::dy, x::dx] for x, y, dx, dy in passes]
    rows = b"".join(_rows(part, depth, tuple(filters)) for part in parts if part.size)
    header = struct.pack(">IIBBBBB", width, height, depth, color, 0, 0, int(interlaced))
    middle = b"".join(chunk(*item) for item in chunks)
    return SIGNATURE + chunk(b"IHDR", header) + middle + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def write_png_file(path: Path, image: np.ndarray, **settings) -> Path:
    path.write_bytes(png_bytes(image, **settings))
    return path


def _rows(image: np.ndarray, depth: int, filters: tuple[int, ...]) -> bytes:
    """Filter each row: 0 none, 1 left, 2 up, 3 mean of both, 4 Paeth."""
    bits = (image.reshape(len(image), -1)[..., None] >> np.arange(depth)[::-1]) & 1
    lines = np.packbits(bits.reshape(len(image), -1).astype(np.uint8), axis=1).astype(int)
    step = max(1, depth * image.shape[-1] // 8)
    out, above = b"", np.zeros(lines.shape[1] + step, int)
    for y, line in enumerate(lines):
        kind, padded = filters[y % len(filters)], np.concatenate([np.zeros(step, int), line])
        left, up, corner = padded[:-step], above[step:], above[:-step]
        guess = {0: 0 * line, 1: left, 2: up, 3: (left + up) // 2, 4: _paeth(left, up, corner)}[kind]
        out += bytes([kind]) + ((line - guess) % 256).astype(np.uint8).tobytes()
        above = padded
    return out


def _paeth(left: np.ndarray, up: np.ndarray, corner: np.ndarray) -> np.ndarray:
    estimate = left + up - corner
    a, b, c = abs(estimate - left), abs(estimate - up), abs(estimate - corner)
    return np.where((a <= b) & (a <= c), left, np.where(b <= c, up, corner))


def unfiltered(rows: list[bytes], step: int) -> bytes:
    """Return the bytes of filtered rows (section 9 of the specification); ``step`` is the size of a pixel in bytes."""
    above, out = bytes(len(rows[0]) - 1), b""
    for row in rows:
        line = bytearray()
        for k, byte in enumerate(row[1:]):
            left, corner = (line[k - step], above[k - step]) if k >= step else (0, 0)
            options = (0, left, above[k], (left + above[k]) // 2, int(_paeth(*map(np.int64, (left, above[k], corner)))))
            line.append((byte + options[row[0]]) % 256)
        above = bytes(line)
        out += above
    return out
