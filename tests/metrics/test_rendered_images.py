"""Metrics of single frames on a rendered clip, each against an independent implementation."""

import csv
import math
import subprocess
import sys

import numpy as np
import OpenEXR
import pytest
import torch
from PIL import Image
from scipy.ndimage import map_coordinates
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from supersampling.metrics.base import Moment
from supersampling.metrics.flip import FLIP, FLIPHDR
from supersampling.metrics.image import psnr, ssim_gauss11, ssim_uniform11, ssim_zero_pad11
from supersampling.metrics.prepare import EightBit
from supersampling.metrics.radiance import psnr_hdr_mu
from supersampling.metrics.regions import Regions
from supersampling.metrics.temporal import Temporal
from supersampling.metrics.video.base import to_bytes

GAUSSIAN = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False}
FRAMES = (0, 3, 7)


def zero_padded_similarity(target, output, **settings):
    """Whole windows of an image with five rows and columns of zeros around it: a window at each pixel."""
    images = (np.pad(image, ((5, 5), (5, 5), (0, 0))) for image in (target, output))
    return structural_similarity(*images, **settings)


def double(image):
    """``(H, W, C)``, float64."""
    return image[0].permute(1, 2, 0).double().numpy()


def pairs(film):
    return [(film.outputs[t], film.targets[t]) for t in FRAMES]


@pytest.mark.parametrize(
    ("metric", "reference", "settings"),
    [
        (psnr, peak_signal_noise_ratio, {}),
        (ssim_gauss11, structural_similarity, {"channel_axis": 2, **GAUSSIAN}),
        (ssim_uniform11, structural_similarity, {"channel_axis": 2, "win_size": 11}),
        (ssim_zero_pad11, zero_padded_similarity, {"channel_axis": 2, **GAUSSIAN}),
    ],
)
def test_psnr_and_ssim_equal_scikit_image(film, metric, reference, settings):
    for output, target in pairs(film):
        expected = reference(double(target), double(output), data_range=1.0, **settings)
        assert metric(output.double(), target.double()).item() == pytest.approx(expected, abs=1e-6)
        assert metric(output, target).item() == pytest.approx(expected, rel=2e-6)  # float32


def test_8_bit_frames_equal_scikit_image_on_bytes(film):
    for output, target in pairs(film):
        bytes_of = to_bytes(target), to_bytes(output)
        rounded = EightBit()(output, target)
        assert psnr(rounded, target).item() == pytest.approx(
            peak_signal_noise_ratio(*bytes_of, data_range=255), abs=1e-4
        )
        expected = structural_similarity(*bytes_of, win_size=11, channel_axis=2, data_range=255)
        assert ssim_uniform11(rounded, target).item() == pytest.approx(expected, abs=1e-5)


def test_mu_law_psnr_equals_scikit_image_of_the_compressed_radiance(film):
    for t in FRAMES:
        output, target = film.radiance[t]
        compressed = [np.log(1 + 5000 * double(x)) / np.log(5001) for x in (target, output)]
        expected = peak_signal_noise_ratio(*compressed, data_range=1.0)
        assert psnr_hdr_mu(output.double(), target.double()).item() == pytest.approx(expected, abs=1e-6)


def flip_command(folder, *options):
    """The mean that the tool's command line writes for ``target.*`` and ``output.*``."""
    kind = "exr" if (folder / "target.exr").exists() else "png"
    files = ["-r", f"target.{kind}", "-t", f"output.{kind}", "-c", "flip.csv", "-v", "0"]
    code = "from flip_evaluator.flip_python_api import main; main()"
    subprocess.run([sys.executable, "-c", code, *files, *options], cwd=folder, check=True)
    with open(folder / "flip.csv") as file:
        row = next(csv.DictReader(file, skipinitialspace=True))
    return float(row["Mean"].strip('"'))


def test_flip_equals_the_tools_command_line_on_png(film, tmp_path):
    for name, image in zip(("output", "target"), pairs(film)[1]):
        Image.fromarray(to_bytes(image)).save(tmp_path / f"{name}.png")
    output, target = pairs(film)[1]
    expected = flip_command(tmp_path)
    assert expected > 0.05
    assert FLIP()(Moment(output=EightBit()(output, target), target=target))["flip"] == pytest.approx(expected, abs=1e-4)


def test_hdr_flip_equals_the_tools_command_line_on_exr(film, tmp_path):
    for name, image in zip(("output", "target"), film.radiance[3]):
        pixels = image[0].permute(1, 2, 0).contiguous().numpy()
        with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": pixels}) as file:
            file.write(str(tmp_path / f"{name}.exr"))
    expected = flip_command(tmp_path, "-cstart", "-3", "-cstop", "3", "-n", "6")
    assert expected > 0.05
    assert FLIPHDR(start=-3, stop=3, number=6)(film.moment(3))["flip_hdr"] == pytest.approx(expected, abs=1e-4)


def positions(motion, height, width):
    """Rows and columns that the previous frame is read at, by scipy: motion ``(1, 2, h, w)`` scaled up, in float64."""
    low = motion[0].double().numpy()
    y, x = np.mgrid[0:height, 0:width] + 0.5
    places = (y * low.shape[1] / height - 0.5, x * low.shape[2] / width - 0.5)
    dx, dy = (map_coordinates(plane, places, order=1, mode="nearest") for plane in low)
    return y + dy * height - 0.5, x + dx * width - 0.5, dx * width, dy * height


def test_temporal_losses_equal_scipys_interpolation(film):
    for t in (1, 5):
        moment = film.moment(t)
        now = double(moment.output) - double(moment.target)
        before = double(moment.previous[0]) - double(moment.previous[1])
        rows, columns, _, _ = positions(moment.motion, *now.shape[:2])
        carried = np.stack(
            [map_coordinates(before[..., c], (rows, columns), order=1, mode="nearest") for c in range(3)], axis=-1
        )
        expected = {"spatial": (abs(now) + abs(carried)).mean(), "temporal": abs(now - carried).mean()}
        assert Temporal()(moment) == pytest.approx(expected, rel=1e-4)


def test_regions_equal_numpys_on_scipys_interpolation(film):
    for t in (1, 2):
        moment = film.moment(t)
        output, target = double(moment.output), double(moment.target)
        height, width = target.shape[:2]
        rows, columns, x, y = positions(moment.motion, height, width)
        _, _, dual_x, dual_y = positions(moment.motion_dual, height, width)
        still = (abs(x) < 0.01) & (abs(y) < 0.01)
        hidden = np.maximum(abs(dual_x - x), abs(dual_y - y)) >= 0.1 * 4  # a low-resolution pixel is four
        hidden |= (rows < -0.5) | (rows > height - 0.5) | (columns < -0.5) | (columns > width - 0.5)
        expected = {"fraction_disoccluded": hidden.mean(), "fraction_static": still.mean()}
        names = ("psnr_disoccluded", "psnr_elsewhere", "psnr_static", "psnr_moving")
        for name, where in zip(names, (hidden, ~hidden, still, ~still)):
            expected[name] = -10 * math.log10(((output - target)[where] ** 2).mean())
        assert 0.01 < hidden.mean() < 0.2 < still.mean() < 0.95
        assert Regions()(moment) == pytest.approx(expected, abs=1e-3)


def test_first_frame_has_no_temporal_value(film):
    for metric in (Temporal(), Regions()):
        assert all(math.isnan(value) for value in metric(film.moment(0)).values())
        assert all(torch.isfinite(torch.tensor(value)) for value in metric(film.moment(1)).values())
