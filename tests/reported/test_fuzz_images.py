"""Random and damaged images: the values that were written, or one sentence."""

import itertools
import os
import subprocess
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest
from exr_files import SIZE, Content, random_exr
from png_files import CHANNELS, SIGNATURE, chunk, png_bytes, unfiltered

from supersampling.data.readers.exr import OPAQUE, read_exr, read_opaque_exr
from supersampling.data.readers.png import DEPTHS, Png, rgba8
from supersampling.data.readers.png_images import read_display_png, read_png, read_png_colors
from supersampling.errors import UserError

SECONDS = float(os.environ.get("FUZZ_SECONDS", "20")) / 5
SEED = int(os.environ.get("FUZZ_SEED", "1"))
ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow


def inputs(folder):
    """Yield random generators until the time is over; the number of the input stays in a file."""
    start = time.monotonic()
    for number in itertools.count():
        if time.monotonic() - start > SECONDS:
            return
        (folder / "number").write_text(f"seed {SEED}, input {number}")
        yield np.random.default_rng([SEED, number])


def attempt(read, *arguments):
    """Return the values, or the sentence of a `UserError`."""
    try:
        return read(*arguments)
    except UserError as error:
        sentence = str(error)
    assert "\n" not in sentence
    return sentence


def expected_exr(content: Content, choices, names):
    """Return the channels of the layer that is meant, None if that is unclear or their values are not to be used."""
    layers = {}
    for number, (_, _, planes) in enumerate(content.parts):
        for name in planes:
            layers.setdefault((number, name.rpartition(".")[0]), set()).add(name.rpartition(".")[2])
    candidates = [(key, choice) for key, present in layers.items() for choice in choices if set(choice) <= present]
    if len({part for (part, _), _ in candidates}) != 1:
        return None
    candidates = [c for c in candidates if not c[0][1]] or candidates
    if len(candidates) != 1:
        return None
    ((part, layer), choice) = candidates[0]
    _, data, planes = content.parts[part]
    left, top, right, bottom = content.display
    of_layer = {n.rpartition(".")[2]: p for n, p in planes.items() if n.rpartition(".")[0] == layer}
    if any((part, f"{layer}.{n}".lstrip(".")) in content.coarse for n in of_layer):
        return None
    if data[0] > left or data[1] > top or data[2] < right or data[3] < bottom:
        return None
    inside = slice(top - data[1], bottom + 1 - data[1]), slice(left - data[0], right + 1 - data[0])
    opaque = names == "opaque" and "A" in of_layer
    exact = np.stack([of_layer[n][inside].astype(np.float64) for n in choice + "A" * opaque], axis=-1)
    if not np.isfinite(exact).all() or (exact.astype(np.float32) != exact).any():
        return None
    if opaque and (exact[..., -1] < OPAQUE).any():
        return None
    return exact[..., : len(choice)]


@pytest.mark.parametrize(
    ("read", "choices", "names"),
    [
        (lambda p: read_opaque_exr(p, SIZE), ("RGB",), "opaque"),
        (lambda p: read_exr(p, SIZE, ("R", "Y", "Z")), ("R", "Y", "Z"), "data"),
    ],
    ids=["frames", "depth"],
)
def test_random_exr(tmp_path, read, choices, names):
    path, count = tmp_path / "a.exr", {True: 0, False: 0}
    for rng in inputs(tmp_path):
        content = random_exr(path, rng)
        values, expected = attempt(read, path), expected_exr(content, choices, names)
        count[expected is None] += 1
        number = (tmp_path / "number").read_text()
        if expected is None:
            assert isinstance(values, str), (number, content)
        else:
            assert not isinstance(values, str), (number, values)
            np.testing.assert_array_equal(values, expected, number)
    assert min(count.values()) > 0, count


def random_png(rng):
    """Return the bytes of a valid file, its integers, its type and its depth."""
    color = int(rng.choice(list(CHANNELS)))
    depth = int(rng.choice(DEPTHS[color]))
    width, height = (int(n) for n in rng.integers(1, 20, 2))
    image = rng.integers(0, 1 << depth, (height, width, CHANNELS[color]))
    if rng.random() < 0.5 and color in (4, 6):
        image[..., -1] = (1 << depth) - 1
    chunks = [(b"PLTE", rng.bytes(3 << depth))] if color == 3 else []
    chunks += [[(b"tEXt", b"a\0b")], [(b"sRGB", b"\0")], [(b"zzZz", rng.bytes(9))], []][rng.integers(4)]
    filters = [int(f) for f in rng.integers(0, 5, 7)]
    data = png_bytes(image, color=color, depth=depth, interlaced=bool(rng.integers(2)), filters=filters, chunks=chunks)
    return data + rng.bytes(int(rng.integers(0, 3))), image, color, depth


def test_random_png(tmp_path):
    path = tmp_path / "a.png"
    for rng in inputs(tmp_path):
        data, image, color, depth = random_png(rng)
        path.write_bytes(data)
        number, size, highest = (tmp_path / "number").read_text(), image.shape[1::-1], (1 << depth) - 1
        shares = (image / highest).astype(np.float32)
        read = [attempt(read_display_png, path, size), attempt(read_png_colors, path, size)]
        if color in (2, 6):
            np.testing.assert_array_equal(read[1], shares[..., :3], number)
        opaque = color == 2 or (color == 6 and (image[..., 3] == highest).all())
        assert isinstance(read[0], str) is not opaque, (number, read[0])
        if opaque:
            np.testing.assert_array_equal(read[0], read[1], number)
        stored = attempt(read_png, path, size, 3)
        assert isinstance(stored, str) is not (color in (2, 6) and depth == 8), (number, stored)
        if color != 3:
            near = np.floor(image / highest * 255.0 + 0.5)
            np.testing.assert_array_equal(rgba8(Png(data, "a"))[..., 0], near[..., 0], number)


def test_random_rows_of_png(tmp_path):
    """Random bytes in place of filtered rows, against the filters of the specification, byte by byte."""
    path = tmp_path / "a.png"
    for rng in inputs(tmp_path):
        width, height = (int(n) for n in rng.integers(1, 9, 2))
        depth, color = int(rng.choice([8, 16])), 2
        step = 3 * depth // 8
        rows = [bytes([rng.integers(0, 5 + (rng.random() < 0.05))]) + rng.bytes(step * width) for _ in range(height)]
        header = width.to_bytes(4, "big") + height.to_bytes(4, "big") + bytes([depth, color, 0, 0, 0])
        packed = zlib.compress(b"".join(rows))
        cut = int(rng.integers(0, len(packed)))
        parts = ((b"IHDR", header), (b"IDAT", packed[:cut]), (b"IDAT", packed[cut:]), (b"IEND", b""))
        path.write_bytes(SIGNATURE + b"".join(chunk(*part) for part in parts))
        values, number = attempt(read_display_png, path, (width, height)), (tmp_path / "number").read_text()
        if any(row[0] > 4 for row in rows):
            assert isinstance(values, str), number
            continue
        exact = np.frombuffer(unfiltered(rows, step), f">u{depth // 8}").reshape(height, width, 3)
        np.testing.assert_array_equal(values, exact.astype(np.float32) / np.float32((1 << depth) - 1), number)


@pytest.mark.parametrize("kind", ["png", "exr"])
def test_damaged_files(tmp_path, kind):
    """In a process of its own, as a decoder may crash."""
    paths = os.pathsep.join(str(ROOT / folder) for folder in ("src", "tests/data"))
    result = subprocess.run(
        [sys.executable, ROOT / "tests/reported/image_mutations.py", kind, str(SEED), f"{SECONDS / 2}", tmp_path],
        capture_output=True,
        text=True,
        errors="replace",
        timeout=SECONDS + 300.0,
        env={**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"},
    )
    number = (tmp_path / "number").read_text()
    assert result.returncode == 0, (number, str(tmp_path / f"current.{kind}"), result.stderr[-2000:])
