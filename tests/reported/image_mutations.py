"""Damages image files and reads them, in a process of its own, since a decoder may crash.

``python image_mutations.py KIND SEED SECONDS FOLDER`` reads ``FOLDER/current.KIND`` over and over; the file stays there
when the process ends early.
"""

import itertools
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from exr_files import EXACT, LOSSY, SIZE, random_exr
from png_files import SIGNATURE, chunk, png_bytes

from supersampling.errors import UserError

Rng = np.random.Generator


def mutate(data: bytes, rng: Rng) -> bytes:
    """Replace, remove or repeat a few bytes; half of the places are near the beginning, where the header is."""
    for _ in range(rng.integers(1, 5)):
        place = int(rng.integers(0, len(data) if rng.random() < 0.5 else min(len(data), 400)))
        span = int(rng.integers(1, 5))
        kind = rng.integers(0, 5)
        fresh = rng.choice([rng.bytes(span), b"\xff" * span, b"\0" * span, b"\x7f" + b"\xff" * 3])
        middle = {0: fresh, 1: b"", 2: 2 * data[place : place + span], 3: bytes([data[place] ^ 1 << rng.integers(8)])}
        data = data[:place] + middle.get(int(kind), fresh) + data[place + (1 if kind == 3 else span) :]
        if not data:
            return b"\0"
    return data


def mutated_png(rng: Rng) -> tuple[bytes, np.ndarray]:
    """Return a damaged file whose checksums are right in half of the cases, and the image before."""
    color = int(rng.choice([2, 6]))
    depth = int(rng.choice([8, 16]))
    image = rng.integers(0, 1 << depth, (SIZE[1], SIZE[0], 3 if color == 2 else 4))
    data = png_bytes(image, color=color, depth=depth, interlaced=bool(rng.integers(2)), filters=range(5))
    if rng.random() < 0.5:
        return mutate(data, rng), image
    header, middle = data[16:29], data[41:-16]
    if rng.random() < 0.5:
        header = mutate(header, rng)
    else:
        middle = mutate(middle, rng)
    parts = ((b"IHDR", header), (b"IDAT", middle), (b"IEND", b""))
    return SIGNATURE + b"".join(chunk(*part) for part in parts), image


def read_png_file(path: Path, rng: Rng) -> None:
    """Read a damaged file: an error, or the image that was written."""
    from supersampling.data.readers.png_images import read_display_png, read_png_colors

    data, image = mutated_png(rng)
    path.write_bytes(data)
    for read in (read_display_png, read_png_colors):
        try:
            values = read(path, SIZE)
        except UserError:
            continue
        highest = np.float32(255 if image.max() < 256 else 65535)
        np.testing.assert_array_equal(values, image[..., :3].astype(np.float32) / highest)


def read_exr_file(path: Path, rng: Rng) -> None:
    """Read a damaged file: an error, or finite values of the right shape; the format has no checksums."""
    from supersampling.data.readers.exr import exr_size, read_exr, read_opaque_exr

    random_exr(path, rng, EXACT + LOSSY)
    path.write_bytes(mutate(path.read_bytes(), rng))
    reads: tuple[Callable[[], object], ...] = (
        lambda: exr_size(path),
        lambda: read_opaque_exr(path, SIZE),
        lambda: read_exr(path, SIZE, ("R", "Y", "Z")),
    )
    for read in reads:
        try:
            values = read()
        except UserError:
            continue
        if isinstance(values, np.ndarray):
            assert values.shape[:2] == SIZE[::-1]
            assert np.isfinite(values).all()


READERS = {"png": read_png_file, "exr": read_exr_file}

if __name__ == "__main__":
    kind, seed, seconds, folder = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), Path(sys.argv[4])
    start = time.monotonic()
    for number in itertools.count():
        if time.monotonic() - start > seconds:
            break
        (folder / "number").write_text(f"seed {seed}, input {number}")
        READERS[kind](folder / f"current.{kind}", np.random.default_rng([seed, number]))
    print(f"{number} inputs")
