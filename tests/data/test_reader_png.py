"""PNG images of captures and frames: exact values, or one sentence."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image, ImageCms
from png_files import CHANNELS, SIGNATURE, chunk, png_bytes, write_png_file

from supersampling.data.readers.png import DEPTHS, Png, rgba8
from supersampling.data.readers.png_images import read_display_png, read_png, read_png_colors
from supersampling.errors import UserError

SIZE = (13, 9)


def random_image(depth, channels=3, seed=0):
    return np.random.default_rng(seed).integers(0, 1 << depth, (SIZE[1], SIZE[0], channels))


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("color", "depth"), [(c, d) for c in (0, 2, 4, 6) for d in DEPTHS[c]])
def test_every_type_without_palette_is_decoded_exactly(color, depth, interlaced):
    image = random_image(depth, CHANNELS[color])
    png = Png(png_bytes(image, color=color, depth=depth, interlaced=interlaced, filters=range(5)), "a")
    scale = 255 // ((1 << depth) - 1) if color == 0 and depth < 8 else 1
    np.testing.assert_array_equal(png.pixels(), image * scale)


@pytest.mark.parametrize("read", [read_display_png, read_png_colors])
@pytest.mark.parametrize("depth", [8, 16])
def test_colours_keep_all_their_bits(tmp_path, read, depth):
    image = random_image(depth)
    path = write_png_file(tmp_path / "a.png", image, depth=depth)
    np.testing.assert_array_equal(read(path, SIZE), image.astype(np.float32) / np.float32((1 << depth) - 1))


def test_alpha_of_captures_is_not_read(tmp_path):
    image = random_image(16, 4)
    path = write_png_file(tmp_path / "a.png", image, depth=16, color=6)
    np.testing.assert_array_equal(read_png_colors(path, SIZE), image[..., :3].astype(np.float32) / np.float32(65535))


def test_sixteen_bit_image_is_not_cut_to_eight(tmp_path):
    path = write_png_file(tmp_path / "a.png", random_image(16, 4), depth=16, color=6)
    with pytest.raises(UserError, match=r"a\.png is an image of type 16-bit RGBA: export it as 8-bit RGBA"):
        read_png(path, SIZE, 4)


def test_nearly_opaque_pixel_of_sixteen_bits_is_transparent(tmp_path):
    image = np.full((SIZE[1], SIZE[0], 4), 65535)
    image[2, 3, 3] = 65534
    path = write_png_file(tmp_path / "a.png", image, depth=16, color=6)
    with pytest.raises(UserError, match=r"1 transparent pixels"):
        read_display_png(path, SIZE)


def profile(matrix_name):
    """An sRGB profile, or one of a different space."""
    made = ImageCms.createProfile(matrix_name)
    return b"name\0\0" + zlib.compress(ImageCms.ImageCmsProfile(made).tobytes())


def primaries(*values):
    return b"cHRM", struct.pack(">8I", *values)


def exif(orientation):
    tags = Image.Exif()
    tags[0x0112] = orientation
    return b"eXIf", tags.tobytes().removeprefix(b"Exif\0\0")


SRGB = primaries(31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
P3 = primaries(31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000)
LINEAR = (b"gAMA", struct.pack(">I", 100000))


@pytest.mark.parametrize(
    "chunks",
    [
        [(b"sRGB", b"\0"), LINEAR, P3],  # sRGB decides
        [(b"gAMA", struct.pack(">I", 45455)), SRGB],
        [(b"gAMA", struct.pack(">I", 45000))],
        [(b"iCCP", profile("sRGB")), LINEAR],
        [(b"cICP", b"\1\x0d\0\1"), LINEAR],
        [(b"sBIT", b"\5\6\5"), (b"pHYs", struct.pack(">IIB", 2, 1, 0)), (b"tEXt", b"a\0b")],
        [(b"acTL", struct.pack(">II", 1, 0))],
        [exif(1)],
        [(b"eXIf", b"no Exif")],
    ],
)
def test_srgb_and_no_statement_are_read(tmp_path, chunks):
    image = random_image(8)
    path = write_png_file(tmp_path / "a.png", image, chunks=chunks)
    np.testing.assert_array_equal(read_display_png(path, SIZE), image.astype(np.float32) / np.float32(255))


@pytest.mark.parametrize("read", [read_display_png, read_png_colors])
@pytest.mark.parametrize(
    ("chunks", "message"),
    [
        ([LINEAR], r"has colours of gamma 1 \(chunk gAMA\): export it as sRGB"),
        ([P3], r"has colours of other primaries \(chunk cHRM\)"),
        ([(b"iCCP", profile("XYZ"))], r"has colours of the profile name \(chunk iCCP\)"),
        ([(b"iCCP", b"P3\0\0damaged")], r"has colours of the profile P3 \(chunk iCCP\)"),
        ([(b"iCCP", b"")], r"has colours of the profile  ?\(chunk iCCP\)"),
        ([(b"cICP", b"\x09\x10\0\1"), (b"sRGB", b"\0")], r"has colours of the space 9-16-0-1 \(chunk cICP\)"),
        ([(b"acTL", struct.pack(">II", 3, 0))], r"is an animation of 3 frames"),
        ([exif(6)], r"is to be turned or mirrored \(Exif orientation 6\): export it upright"),
        ([(b"tRNS", struct.pack(">HHH", 1, 2, 3))], r"has a transparent colour \(chunk tRNS\)"),
        ([(b"CgBI", b"1234")], r"has the unknown chunk CgBI"),
    ],
)
def test_foreign_statements_are_errors(tmp_path, read, chunks, message):
    path = write_png_file(tmp_path / "a.png", random_image(8), chunks=chunks)
    with pytest.raises(UserError, match=r"a\.png " + message):
        read(path, SIZE)


@pytest.mark.parametrize(("color", "name"), [(0, "8-bit grey"), (3, "8-bit palette"), (4, "8-bit grey with alpha")])
def test_types_other_than_rgb_are_errors(tmp_path, color, name):
    chunks = [(b"PLTE", bytes(768))] if color == 3 else []
    path = write_png_file(tmp_path / "a.png", random_image(8, CHANNELS[color]), color=color, chunks=chunks)
    with pytest.raises(UserError, match=f"is an image of type {name}: export it as RGB"):
        read_display_png(path, SIZE)


@pytest.mark.parametrize("kind", ["JPEG", "WEBP", "TIFF", "BMP"])
def test_format_behind_the_name_is_stated(tmp_path, kind):
    Image.new("RGB", SIZE).save(tmp_path / "a.png", format=kind)
    with pytest.raises(UserError, match=rf"a\.png is not a readable PNG image \(its content is {kind}\)"):
        read_display_png(tmp_path / "a.png", SIZE)


def with_data(data):
    header = struct.pack(">IIBBBBB", *SIZE, 8, 2, 0, 0, 0)
    return SIGNATURE + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


ROW = 1 + 3 * SIZE[0]
WHOLE = zlib.compress(bytes(ROW * SIZE[1]))


@pytest.mark.parametrize(
    "data",
    [
        zlib.compress(bytes(ROW * SIZE[1] - 1)),  # libpng's callers crash here
        zlib.compress(bytes(ROW * SIZE[1] + 1)),
        WHOLE[:-4],
        WHOLE[:-1] + b"x",
        b"",
        b"no stream",
        zlib.compress(bytes([5, *[0] * (ROW - 1)]) + bytes(ROW * (SIZE[1] - 1))),
    ],
    ids=["short", "long", "no checksum", "wrong checksum", "empty", "no zlib", "unknown filter"],
)
def test_damaged_pixels_with_right_checksums_are_errors(tmp_path, data):
    (tmp_path / "a.png").write_bytes(with_data(data))
    with pytest.raises(UserError, match=r"a\.png is truncated or damaged"):
        read_display_png(tmp_path / "a.png", SIZE)


def test_every_damaged_byte_is_an_error():
    data = png_bytes(random_image(8), filters=range(5))
    for place in range(len(data)):
        with pytest.raises(UserError):
            Png(data[:place] + bytes([data[place] ^ 0x10]) + data[place + 1 :], "a").pixels()


def test_bytes_after_the_end_change_nothing(tmp_path):
    image = random_image(8)
    (tmp_path / "a.png").write_bytes(png_bytes(image) + b"trailing")
    np.testing.assert_array_equal(read_png(tmp_path / "a.png", SIZE, 3), image)


def test_folder_instead_of_image(tmp_path):
    (tmp_path / "a.png").mkdir()
    with pytest.raises(UserError, match=r"a\.png cannot be opened"):
        read_display_png(tmp_path / "a.png", SIZE)


@pytest.mark.parametrize("depth", [1, 2, 4, 8, 16])
def test_eight_bit_texture_of_grey_with_transparent_value(depth):
    image = random_image(depth, 1)
    key = int(image[0, 0, 0])
    png = Png(png_bytes(image, color=0, depth=depth, chunks=[(b"tRNS", struct.pack(">H", key))]), "a")
    grey = np.floor(image / ((1 << depth) - 1) * 255 + 0.5)
    expected = np.concatenate([grey, grey, grey, np.where(image == key, 0, 255)], axis=-1)
    np.testing.assert_array_equal(rgba8(png), expected)


@pytest.mark.parametrize("color", [2, 4, 6])
def test_eight_bit_texture_is_rounded_to_nearest(color):
    image = random_image(16, CHANNELS[color])
    near = np.floor(image / 257 + 0.5)
    expected = {
        2: lambda: np.dstack([near, np.full_like(near[..., :1], 255)]),
        4: lambda: near[..., [0, 0, 0, 1]],
        6: lambda: near,
    }[color]()
    np.testing.assert_array_equal(rgba8(Png(png_bytes(image, color=color, depth=16), "a")), expected)
