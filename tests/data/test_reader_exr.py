"""EXR images of captures and frames: layers, parts, windows and types, read exactly or refused by name."""

import numpy as np
import OpenEXR
import pytest

from supersampling.data.readers.exr import exr_size, read_exr, read_exr_colors, read_opaque_exr
from supersampling.errors import UserError

SIZE = (20, 12)
RNG = np.random.default_rng(0)
IMAGE, SECOND = (RNG.random((SIZE[1], SIZE[0], 3)).astype(np.float32) for _ in range(2))


def planes(image, prefix="", names="RGB"):
    return {f"{prefix}{name}": np.ascontiguousarray(image[..., k]) for k, name in enumerate(names)}


def write(path, channels, **header):
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, channels).write(str(path))
    return path


def window(left, top, right, bottom):
    return np.array([left, top], dtype=np.int32), np.array([right, bottom], dtype=np.int32)


DISPLAY = window(0, 0, SIZE[0] - 1, SIZE[1] - 1)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.exr"


@pytest.mark.parametrize(
    ("first", "second"),
    [("", "albedo."), ("", "Z."), ("", "right."), ("", "a.b.c."), ("ViewLayer.Combined.", "ViewLayer.Mask.XY")],
)
def test_layer_without_a_name_or_the_only_one_is_the_image(path, first, second):
    write(path, planes(SECOND, second) | planes(IMAGE, first))
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)


@pytest.mark.parametrize(
    ("first", "second"), [("ViewLayer.Combined.", "ViewLayer.DiffCol."), ("left.", "right."), ("a.", "a.b.")]
)
def test_several_named_layers_are_listed(path, first, second):
    write(path, planes(IMAGE, first) | planes(SECOND, second))
    with pytest.raises(UserError, match=rf"has R, G, B in several layers \({first[:-1]}, {second[:-1]}\)"):
        read_exr(path, SIZE, ("RGB",))


def test_layers_of_different_channels_are_listed(path):
    write(path, planes(IMAGE, "Combined.") | planes(SECOND, "Vector.", "XYZ"))
    with pytest.raises(UserError, match=r"has R, G or X, Y in several layers \(Combined, Vector\)"):
        read_exr(path, SIZE, ("RG", "XY"))


def test_two_choices_in_one_layer_are_listed(path):
    write(path, planes(IMAGE) | {"Z": SECOND[..., 0].copy()})
    with pytest.raises(UserError, match=r"has R and Z, and which of them is meant is unknown"):
        read_exr(path, SIZE, ("R", "Y", "Z"))
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)


def test_missing_channels_list_those_of_each_layer(path):
    write(path, planes(IMAGE, "b.", "XYZ") | planes(IMAGE, "a.", "RGA"))
    with pytest.raises(UserError, match=r"has the channels a.A, a.G, a.R, b.X, b.Y, b.Z: export RGB or UV"):
        read_exr(path, SIZE, ("RGB", "UV"))


def write_parts(path, *parts):
    OpenEXR.File(
        [OpenEXR.Part({"type": OpenEXR.scanlineimage, **header}, channels, name) for name, channels, header in parts]
    ).write(str(path))


def test_several_parts_with_the_channels_are_listed(path):
    write_parts(path, ("N", planes(SECOND), {}), ("albedo", planes(SECOND), {}), ("C", planes(IMAGE, "beauty."), {}))
    with pytest.raises(UserError, match=r"has R, G, B in several parts \(N, albedo, C\)"):
        read_exr(path, SIZE, ("RGB",))


def test_damaged_part_is_an_error_and_the_next_one_is_read(path):
    """The library leaves such parts out, so that the numbers of the parts are not their places."""
    plain = {"compression": OpenEXR.NO_COMPRESSION}
    write_parts(path, ("depth", {"Z": SECOND[..., 0].copy()}, plain), ("C", planes(IMAGE), plain))
    data = bytearray(path.read_bytes())
    row = data.index(SECOND[0, :, 0].tobytes())
    data[row - 8 : row - 4] = b"\xff" * 4  # the number of the first row
    path.write_bytes(data)
    with pytest.raises(UserError, match=r"a\.exr is truncated or damaged"):
        read_exr(path, SIZE, ("Z",))
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)


def test_rows_that_were_never_written_are_an_error(path):
    """A renderer that was stopped leaves zeros in the table of the rows' places."""
    write(path, planes(IMAGE), compression=OpenEXR.NO_COMPRESSION)
    data = bytearray(path.read_bytes())
    row = IMAGE[-1].nbytes + 8
    place = (len(data) - row).to_bytes(8, "little")
    assert place in data
    path.write_bytes(data.replace(place, bytes(8))[:-row])
    with pytest.raises(UserError, match=r"a\.exr is truncated"):
        read_exr(path, SIZE, ("RGB",))


def test_only_part_with_the_channels_is_read_in_its_own_window(path):
    wide = np.pad(IMAGE, ((1, 2), (3, 4), (0, 0)), constant_values=np.nan)
    around = {"dataWindow": window(-3, -1, SIZE[0] + 3, SIZE[1] + 1), "displayWindow": DISPLAY}
    write_parts(path, ("depth", {"Z": SECOND[..., 0].copy()}, {"displayWindow": DISPLAY}), ("C", planes(wide), around))
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)
    np.testing.assert_array_equal(read_exr(path, SIZE, ("Z",))[..., 0], SECOND[..., 0])


@pytest.mark.parametrize("origin", [(0, 0), (100, -50)])
def test_pixels_around_the_display_window_are_cropped(path, origin):
    x, y = origin
    wide = np.pad(IMAGE, ((2, 0), (5, 1), (0, 0)), constant_values=7.0)
    data = window(x - 5, y - 2, x + SIZE[0], y + SIZE[1] - 1)
    write(path, planes(wide), dataWindow=data, displayWindow=window(x, y, x + SIZE[0] - 1, y + SIZE[1] - 1))
    assert exr_size(path) == SIZE
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)


@pytest.mark.parametrize(
    ("data", "display"),
    [
        (window(8, 0, 27, 11), DISPLAY),  # elsewhere, same size
        (window(0, -1, 19, 10), DISPLAY),
        (DISPLAY, window(0, 0, 39, 23)),  # a part of the image
        (DISPLAY, window(1, 0, 20, 11)),
    ],
)
def test_windows_that_do_not_cover_the_image_are_refused(path, data, display):
    write(path, planes(IMAGE), dataWindow=data, displayWindow=display)
    for read in (exr_size, lambda p: read_exr(p, SIZE, ("RGB",))):
        with pytest.raises(UserError, match=r"\(data window\) of an image of the pixels .*: export the whole image"):
            read(path)


def test_size_is_that_of_the_display_window(path):
    wide = np.pad(IMAGE, ((0, 1), (0, 1), (0, 0)))
    write(path, planes(wide), displayWindow=DISPLAY, dataWindow=window(0, 0, *SIZE))
    with pytest.raises(UserError, match="has 20x12 pixels: restore the image of 21x13"):
        read_exr(path, (21, 13), ("RGB",))


def test_channels_of_lower_resolution_are_named(path):
    channels = {n: OpenEXR.Channel(n, IMAGE[..., 0].copy(), 2, 2) for n in ("RY", "BY")}
    write(path, {"Y": IMAGE[..., 0].copy(), **channels})
    with pytest.raises(UserError, match=r"has the channels BY, RY, Y: export RGB"):
        read_exr(path, SIZE, ("RGB",))
    with pytest.raises(UserError, match=r"has channels of a lower resolution \(BY, RY\): export Y for every pixel"):
        read_exr(path, SIZE, ("R", "Y", "Z"))


def test_deep_image_is_refused(path):
    samples = np.empty((SIZE[1], SIZE[0]), dtype=object)
    for place in np.ndindex(samples.shape):
        samples[place] = np.ones(2, dtype=np.float32)
    header = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}
    OpenEXR.File(header, dict.fromkeys("RGB", samples)).write(str(path))
    with pytest.raises(UserError, match=r"is a deep image, with several samples for each pixel: export a flat image"):
        read_exr(path, SIZE, ("RGB",))


ACES_CG = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
REC_709 = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)


def test_primaries_matter_for_colours_only(path):
    write(path, planes(IMAGE), chromaticities=ACES_CG)
    with pytest.raises(UserError, match=r"has other primaries than Rec\. 709 \(0\.713 0\.293, .*\): export linear Rec"):
        read_exr_colors(path, SIZE)
    np.testing.assert_array_equal(read_exr(path, SIZE, ("RGB",)), IMAGE)
    write(path, planes(IMAGE), chromaticities=REC_709)
    np.testing.assert_array_equal(read_exr_colors(path, SIZE), IMAGE)


@pytest.mark.parametrize("name", ["lin_ap1_scene", "srgb_rec709_scene"])
def test_named_colour_space_other_than_linear_rec_709(path, name):
    write(path, planes(IMAGE), colorInteropID=name)
    with pytest.raises(UserError, match=f"has colours of the space {name}: export linear Rec. 709"):
        read_exr_colors(path, SIZE)


def test_alpha_of_the_layer_decides_whether_frames_are_opaque(path):
    alpha = np.ones((SIZE[1], SIZE[0]), dtype=np.float16)
    write(path, planes(IMAGE) | {"A": alpha, "mask.A": 0 * alpha})
    np.testing.assert_array_equal(read_opaque_exr(path, SIZE), IMAGE)
    alpha[2, 3:5] = 0.5
    write(path, planes(IMAGE) | {"A": alpha})
    with pytest.raises(UserError, match="has 2 transparent pixels, whose colour is unknown: export it without alpha"):
        read_opaque_exr(path, SIZE)
    np.testing.assert_array_equal(read_exr_colors(path, SIZE), IMAGE)
