"""Values of EXR images: types, compressions, tiles and mipmaps, exact or refused."""

import struct

import numpy as np
import OpenEXR
import pytest

from supersampling.data.readers.exr import read_exr
from supersampling.errors import UserError

SIZE = (20, 12)
RNG = np.random.default_rng(0)
IMAGE = RNG.random((SIZE[1], SIZE[0], 3)).astype(np.float32)


def planes(image, prefix="", names="RGB"):
    return {f"{prefix}{name}": np.ascontiguousarray(image[..., k]) for k, name in enumerate(names)}


def write(path, channels, **header):
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(str(path))
    return path


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.exr"


EXACT = ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "HTJ2K32", "HTJ2K256", "ZSTD")


@pytest.mark.parametrize("order", [OpenEXR.INCREASING_Y, OpenEXR.DECREASING_Y])
@pytest.mark.parametrize("name", [n for n in EXACT if hasattr(OpenEXR, f"{n}_COMPRESSION")])
def test_mixed_types_are_exact_in_lossless_compressions(path, name, order):
    light = np.ldexp(IMAGE[..., 0], RNG.integers(-120, 120, IMAGE.shape[:2])).astype(np.float32)
    half = (60000.0 * IMAGE[..., 1]).astype(np.float16)
    whole = RNG.integers(0, 1 << 24, light.shape).astype(np.uint32)
    compression = getattr(OpenEXR, f"{name}_COMPRESSION")
    write(path, {"R": light, "G": half, "B": whole}, compression=compression, lineOrder=order)
    expected = np.stack([light, half.astype(np.float32), whole.astype(np.float32)], axis=-1)
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), expected)


def test_tiles_are_exact(path):
    tiles = OpenEXR.TileDescription()
    tiles.xSize, tiles.ySize = 7, 5
    write(path, planes(IMAGE), type=OpenEXR.tiledimage, tiles=tiles)
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)


def attribute(name, kind, content):
    return name + b"\0" + kind + b"\0" + struct.pack("<i", len(content)) + content


def mipmap(images, tile):
    """Encode the levels of an image, after the format's file layout; the library writes the first level only."""
    height, width, _ = images[0].shape
    names = b"".join(name + b"\0" + struct.pack("<4i", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    one = struct.pack("<f", 1.0)
    attributes = (
        *((b"channels", b"chlist", names), (b"compression", b"compression", b"\0"), (b"dataWindow", b"box2i", box)),
        *(
            (b"displayWindow", b"box2i", box),
            (b"lineOrder", b"lineOrder", b"\0"),
            (b"screenWindowWidth", b"float", one),
        ),
        *((b"pixelAspectRatio", b"float", one), (b"screenWindowCenter", b"v2f", bytes(8))),
        (b"tiles", b"tiledesc", struct.pack("<IIB", tile, tile, 1)),
    )
    head = struct.pack("<ii", 20000630, 0x202) + b"".join(attribute(*item) for item in attributes) + b"\0"
    chunks = []
    for level, image in enumerate(images):
        for y, x in np.ndindex(-(-image.shape[0] // tile), -(-image.shape[1] // tile)):
            block = image[y * tile : (y + 1) * tile, x * tile : (x + 1) * tile, ::-1]
            content = np.ascontiguousarray(block.transpose(0, 2, 1)).tobytes()
            chunks.append(struct.pack("<5i", x, y, level, level, len(content)) + content)
    places = len(head) + 8 * len(chunks) + np.cumsum([0, *map(len, chunks[:-1])])
    return head + places.astype("<u8").tobytes() + b"".join(chunks)


def test_largest_level_of_a_mipmap_is_read(path):
    levels = [IMAGE, *(RNG.random((h, w, 3)).astype(np.float32) for h, w in ((6, 10), (3, 5), (1, 2), (1, 1)))]
    path.write_bytes(mipmap(levels, 8))
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)


def test_integers_beyond_float32_are_refused(path):
    numbers = np.full((SIZE[1], SIZE[0]), (1 << 24) + 1, dtype=np.uint32)
    write(path, {"Z": numbers})
    with pytest.raises(UserError, match="has integers above 16777216 in Z: export 32-bit floats"):
        read_exr(path, SIZE, ("Z",))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_no_numbers_are_counted(path, value):
    image = IMAGE.copy()
    image[3, 4, 1] = value
    write(path, planes(image))
    with pytest.raises(UserError, match="has 1 values that are NaN or Inf"):
        read_exr(path, SIZE, ("RGB",))


def test_infinity_is_read_where_it_is_permitted(path):
    image = IMAGE.copy()
    image[3, 4, 1] = np.inf
    write(path, planes(image))
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",), infinite=True), image)
    image[3, 4, 0] = np.nan
    write(path, planes(image))
    with pytest.raises(UserError, match="has 1 values that are NaN or Inf"):
        read_exr(path, SIZE, ("RGB",), infinite=True)
