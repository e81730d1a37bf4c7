"""Images with more, or other, content than one picture: layers, parts, windows, and 16 bits."""

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import torch
from capture_files import SIZE, make_source
from png_files import write_png_file

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.readers.qrisp import decode_depth
from supersampling.ops.display import radiance_to_display

LOW = Path("TestSet/World/540p")
COLOR, DEPTH = LOW / "MipBiasMinus1Jittered", LOW / "DepthMipBiasMinus1Jittered"
TARGET = Path("TestSet/World/1080p/Enhanced")


@pytest.fixture
def source(tmp_path):
    """One clip of two frames."""
    return make_source(tmp_path / "world", clips=1, frames=2)


@pytest.fixture
def light(source):
    return DatasetFile(source).read("target_radiance", 0, slice(None)).transpose(0, 2, 3, 1).astype(np.float32)


@pytest.fixture
def score(command, scoring, source, tmp_path):
    """Score the frames of a folder."""

    def run(space="radiance"):
        settings = [f"data.test=[{source}]" if s.startswith("data.test") else s for s in scoring if s != "model=jau"]
        return command("evaluate", *settings, f"frames={tmp_path / 'F'}", f"space={space}", "name=other")

    return run


@pytest.fixture
def write(tmp_path):
    folder = tmp_path / "F"
    folder.mkdir()

    def frames(images, parts):
        for t, image in enumerate(images):
            OpenEXR.File(
                [OpenEXR.Part({"type": OpenEXR.scanlineimage, **h}, c, name) for name, c, h in parts(image)]
            ).write(str(folder / f"{t:04d}.exr"))

    return frames


def planes(image, prefix=""):
    return {f"{prefix}{c}": np.ascontiguousarray(image[..., k]) for k, c in enumerate("RGB")}


def scored(answer):
    """Return the PSNR that the command printed for the frames."""
    assert answer.status == 0, answer.text
    (line,) = (line for line in answer.text.splitlines() if line.startswith("psnr"))
    return float(line.split()[1])


@pytest.fixture
def expected(light, source):
    """Return the PSNR of the target's radiance, shown, against the target."""
    shown = radiance_to_display(torch.from_numpy(light)).numpy().astype(np.float64)
    error = shown - DatasetFile(source).read("target", 0, slice(None)).transpose(0, 2, 3, 1)
    return pytest.approx(np.mean(-10.0 * np.log10(np.square(error).mean(axis=(1, 2, 3)))), abs=2e-4)


def test_layer_without_a_name_is_scored(score, write, light, expected, row):
    write(light, lambda image: [("", planes(1.0 - image, "albedo.") | planes(image), {})])
    assert scored(score()) == expected
    row("17", "EXR: R, G, B beside albedo.R, G, B", "the layer without a name is scored")


def test_several_named_layers_are_listed(score, write, light, row):
    layers = ("ViewLayer.Combined", "ViewLayer.DiffCol")
    write(light, lambda image: [("", planes(image, f"{layers[0]}.") | planes(image, f"{layers[1]}."), {})])
    answer = score()
    sentence = f"0000.exr has R, G, B in several layers ({', '.join(layers)}): export only the one that is meant."
    assert (answer.status, sentence in answer.text) == (2, True), answer.text
    row("17", "EXR: Combined and DiffCol, no layer without a name", sentence)


def test_several_parts_are_listed(score, write, light, row):
    write(light, lambda image: [(name, planes(image), {}) for name in ("N", "albedo", "C")])
    answer = score()
    sentence = "0000.exr has R, G, B in several parts (N, albedo, C): export only the one that is meant."
    assert (answer.status, sentence in answer.text) == (2, True), answer.text
    row("18", "EXR: three parts with R, G, B", sentence)


def window(left, top, right, bottom):
    return np.array([left, top], dtype=np.int32), np.array([right, bottom], dtype=np.int32)


DISPLAY = window(0, 0, SIZE[0] - 1, SIZE[1] - 1)


def test_shifted_data_window_is_refused(score, write, light, row):
    shifted = {"dataWindow": window(8, 0, SIZE[0] + 7, SIZE[1] - 1), "displayWindow": DISPLAY}
    write(light, lambda image: [("", planes(image), shifted)])
    answer = score()
    sentence = (
        "0000.exr has the pixels 8,0 to 103,63 (data window) of an image of the pixels 0,0 to 95,63 (display window): "
        "export the whole image."
    )
    assert (answer.status, sentence in answer.text) == (2, True), answer.text
    row("19", "EXR: the data window begins 8 pixels in", sentence)


def test_larger_data_window_is_cropped(score, write, light, expected, row):
    wide = {"dataWindow": window(-8, -4, SIZE[0] + 7, SIZE[1] + 3), "displayWindow": DISPLAY}
    write(light, lambda image: [("", planes(np.pad(image, ((4, 4), (8, 8), (0, 0)))), wide)])
    assert scored(score()) == expected
    row("19", "EXR: the data window surrounds the display window", "cropped, at its place")


@pytest.fixture
def capture(source, tmp_path):
    return export("qrisp", source, tmp_path / "capture")


@pytest.fixture
def import_it(command, capture, tmp_path):
    def run():
        return command("import_capture", "layout=qrisp", f"path={capture}", "task.scale=2", f"paths.root={tmp_path}")

    return run


def test_sixteen_bit_colour_is_rounded_rather_than_cut(capture, import_it, source, tmp_path, row):
    images = {}
    for place, name in ((COLOR, "color"), (TARGET, "target")):
        stored = DatasetFile(source).read(name, 0, slice(None)).transpose(0, 2, 3, 1)
        images[name] = np.round(stored * 255.0).astype(int) * 257 + 0x60
        images[name][:, :4] = 0xC0
        for t, image in enumerate(images[name]):
            write_png_file(capture / place / f"0000/{t:04d}.png", np.minimum(image, 65535), depth=16)
    answer = import_it()
    assert answer.status == 0, answer.text
    (path,) = (tmp_path / "datasets").glob("*.h5")
    for name, image in images.items():
        stored = DatasetFile(path).read(name, 0, slice(None)).transpose(0, 2, 3, 1)
        np.testing.assert_array_equal(np.round(stored * 255.0), np.floor(np.minimum(image, 65535) / 257.0 + 0.5))
    row("20", "16-bit colour of a QRISP capture", "read in 16 bits; the data set file stores the nearest of 256 steps")


def test_sixteen_bit_depth_is_refused(capture, import_it, row):
    path = capture / DEPTH / "0000/0000.png"
    image = np.random.default_rng(0).integers(0, 65536, (SIZE[1] // 2, SIZE[0] // 2, 4))
    write_png_file(path, image, color=6, depth=16)
    assert decode_depth(image.astype(np.uint8)).shape == (SIZE[1] // 2, SIZE[0] // 2, 1)
    answer = import_it()
    sentence = "0000.png is an image of type 16-bit RGBA: export it as 8-bit RGBA."
    assert (answer.status, sentence in answer.text) == (2, True), answer.text
    row("20", "16-bit depth of a QRISP capture", sentence)
