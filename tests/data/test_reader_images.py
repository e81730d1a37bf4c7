"""Image files from strangers: whatever is in them, one sentence or the image comes out."""

import struct
import zlib

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from supersampling.data.exporters.images import write_exr, write_png
from supersampling.data.readers.exr import exr_size, read_exr
from supersampling.data.readers.png_images import png_size, read_png
from supersampling.errors import UserError

SIZE = (40, 24)


@pytest.fixture
def values():
    return np.random.default_rng(0).random((24, 40, 3)).astype(np.float32)


@pytest.mark.parametrize("half", [False, True])
def test_exr_round_trip_by_channel_name(tmp_path, values, half):
    write_exr(tmp_path / "a.exr", values, "BXA", half)
    read = read_exr(tmp_path / "a.exr", SIZE, ("RGB", "XAB"))
    np.testing.assert_array_equal(read, values.astype(np.float16 if half else np.float32)[..., [1, 2, 0]])
    assert exr_size(tmp_path / "a.exr", ("XAB",)) == SIZE


def test_channels_of_layer(tmp_path, values):
    channels = {f"View.{c}": np.ascontiguousarray(values[..., k]) for k, c in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr", SIZE, ("RGB",)), values)


def test_png_round_trip(tmp_path, values):
    write_png(tmp_path / "a.png", values)
    np.testing.assert_array_equal(read_png(tmp_path / "a.png", SIZE, 3), np.round(values * 255))
    assert png_size(tmp_path / "a.png") == SIZE


@pytest.mark.parametrize("kind", ["png", "exr"])
def test_every_truncation_is_error(tmp_path, values, kind):
    write = {"png": write_png, "exr": lambda p, v: write_exr(p, v, "RGB")}[kind]
    read = {"png": lambda p: read_png(p, SIZE, 3), "exr": lambda p: read_exr(p, SIZE, ("RGB",))}[kind]
    whole, cut = tmp_path / f"whole.{kind}", tmp_path / f"cut.{kind}"
    write(whole, values)
    data = whole.read_bytes()
    for length in {*range(0, len(data) - 16, 97), 0, 1, 4, 8, len(data) // 2}:
        cut.write_bytes(data[:length])
        with pytest.raises(UserError, match=f"cut\\.{kind}"):
            read(cut)


def header_only_png(width, height):
    """A PNG of a few bytes that promises many pixels."""

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize("size", [(5000, 5000), (60000, 60000)])
def test_png_with_oversized_header_is_not_decoded(tmp_path, size):
    (tmp_path / "bomb.png").write_bytes(header_only_png(*size))
    with pytest.raises(UserError, match="bomb.png"):
        png_size(tmp_path / "bomb.png")
    with pytest.raises(UserError, match="bomb.png"):
        read_png(tmp_path / "bomb.png", size, 3)


def test_exr_with_oversized_header_is_not_decoded(tmp_path, values):
    write_exr(tmp_path / "a.exr", values, "RGB")
    data = (tmp_path / "a.exr").read_bytes()
    window = struct.pack("<iiii", 0, 0, 39, 23)
    assert window in data
    (tmp_path / "bomb.exr").write_bytes(data.replace(window, struct.pack("<iiii", 0, 0, 59999, 59999)))
    with pytest.raises(UserError, match="bomb.exr"):
        read_exr(tmp_path / "bomb.exr", SIZE, ("RGB",))


@pytest.mark.parametrize("mode", ["L", "I;16", "P", "LA"])
def test_unsupported_png_modes_are_errors(tmp_path, mode):
    Image.new(mode, SIZE).save(tmp_path / "a.png")
    with pytest.raises(UserError, match="a.png is an image of type"):
        read_png(tmp_path / "a.png", SIZE, 3)


def test_other_format_with_png_suffix(tmp_path):
    Image.new("RGB", SIZE).save(tmp_path / "a.png", format="BMP")
    with pytest.raises(UserError, match="not a readable PNG"):
        read_png(tmp_path / "a.png", SIZE, 3)
