"""The wrapper around the authors' tool: against colour distances worked out by hand, and against the tool on files."""

import math

import flip_evaluator
import numpy as np
import OpenEXR
import pytest
import torch
from PIL import Image

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.flip import FLIP, FLIPHDR

EXPOSURES = {"start": -3, "stop": 3, "number": 6}


def moment(output, target, radiance=False):
    """Return the moment of arrays ``(H, W, 3)``."""
    a, b = (torch.from_numpy(np.asarray(i, np.float32)).permute(2, 0, 1)[None] for i in (output, target))
    return Moment(output=a, target=b, radiance=(a, b) if radiance else None)


def flat(colour, height=9, width=14):
    return np.broadcast_to(np.array(colour), (height, width, 3))


def linear(colour):
    c = np.array(colour, float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def hunted_lab(colour):
    """CIELAB of a linear colour under D65, its chroma scaled by lightness (Andersson et al. 2020, section 4.1.2)."""
    matrix = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = matrix @ np.array(colour) / matrix.sum(axis=1)
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio * (29 / 6) ** 2 / 3 + 4 / 29)
    lightness = 116 * f[1] - 16
    return lightness, *(0.01 * lightness * np.array([500 * (f[0] - f[1]), 200 * (f[1] - f[2])]))


def colour_distance(first, second):
    """FLIP of two flat images, linear colours: its filters and edges have no effect (equations 5 and 8)."""

    def hyab(a, b):
        return (abs(a[0] - b[0]) + math.hypot(a[1] - b[1], a[2] - b[2])) ** 0.7

    most = hyab(hunted_lab((0, 1, 0)), hunted_lab((0, 0, 1)))
    error, knee = hyab(hunted_lab(first), hunted_lab(second)), 0.4 * most
    return 0.95 * error / knee if error < knee else 0.95 + 0.05 * (error - knee) / (most - knee)


PAIRS = [((0.8, 0.3, 0.1), (0.2, 0.4, 0.5)), ((0.5, 0.5, 0.5), (0.52, 0.5, 0.45)), ((0, 0, 0), (0.2, 0.2, 0.2))]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_flat_colours_by_hand(first, second):
    expected = colour_distance(linear(first), linear(second))
    assert expected > 0.05
    assert FLIP()(moment(flat(first), flat(second)))["flip"] == pytest.approx(expected, abs=1e-4)
    swapped = colour_distance(linear(first[::-1]), linear(second[::-1]))
    if first != first[::-1]:
        assert abs(swapped - expected) > 1e-3  # so that the channels' order shows


def aces(radiance, stops):
    """Narkowicz's curve, after the factor 0.6 that it expects."""
    x = 0.6 * 2.0**stops * np.array(radiance)
    return np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)


@pytest.mark.parametrize(("first", "second"), [((4, 3, 2), (5, 3, 2)), ((0.03, 0.02, 0.02), (0.02, 0.02, 0.03))])
def test_flat_radiance_by_hand(first, second):
    by_exposure = [colour_distance(aces(first, s), aces(second, s)) for s in np.linspace(-3, 3, 6)]
    values = FLIPHDR(**EXPOSURES)(moment(flat(first), flat(second), True))
    assert values["flip_hdr"] == pytest.approx(max(by_exposure), abs=2e-4)
    assert max(by_exposure) > max(by_exposure[2:4])  # a middle exposure alone would not do


@pytest.fixture
def pictures():
    """Two pictures, wider than high, whose rows, columns and channels all differ."""
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:30, 0:45]
    picture = np.stack([0.5 + 0.4 * np.sin(0.3 * x * (1 + c) + 0.1 * y) for c in range(3)], axis=-1)
    return np.clip(picture + 0.1 * rng.standard_normal(picture.shape), 0, 1), picture


def test_equals_the_tool_on_files(pictures, tmp_path):
    bytes_of = [np.round(255 * p).astype(np.uint8) for p in pictures]
    paths = [str(tmp_path / name) for name in ("test.png", "reference.png")]
    for image, path in zip(bytes_of, paths):
        Image.fromarray(image).save(path)
    expected = flip_evaluator.evaluate(paths[1], paths[0], "LDR")[1]
    output, target = (b / np.float32(255) for b in bytes_of)
    assert expected > 0.01
    assert FLIP()(moment(output, target))["flip"] == pytest.approx(expected, abs=1e-4)


def test_equals_the_tool_on_hdr_files(pictures, tmp_path):
    images = [(8 * p**3).astype(np.float32) for p in pictures]
    paths = [str(tmp_path / name) for name in ("test.exr", "reference.exr")]
    for image, path in zip(images, paths):
        with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": image}) as file:
            file.write(path)
    parameters = {"startExposure": -2.0, "stopExposure": 4.0, "numExposures": 3}
    expected = flip_evaluator.evaluate(paths[1], paths[0], "HDR", parameters=parameters)[1]
    values = FLIPHDR(start=-2, stop=4, number=3)(moment(*images, True))
    assert expected > 0.01
    assert values["flip_hdr"] == pytest.approx(expected, abs=1e-4)


def test_default_distance_is_the_tools(pictures):
    assert flip_evaluator.evaluate(*(p.astype(np.float32) for p in pictures), "LDR")[2]["ppd"] == pytest.approx(
        FLIP()._parameters["ppd"], abs=1e-3
    )


def test_nearer_viewer_sees_more_of_fine_pattern():
    y, x = np.mgrid[0:40, 0:40]
    grey = np.full((40, 40, 3), 0.5)
    fine = grey + 0.1 * (((x + y) % 2) * 2 - 1)[..., None]
    far, near = (FLIP(ppd)(moment(fine, grey))["flip"] for ppd in (67.0, 20.0))
    assert near > 1.5 * far


@pytest.mark.parametrize("level", [0.0, 0.3, 1.0])
def test_identical_and_black_frames_score_0(level):
    same = moment(flat((level,) * 3, 2, 3), flat((level,) * 3, 2, 3), True)  # smaller than any filter, too
    assert FLIP()(same)["flip"] == 0.0
    assert FLIPHDR(**EXPOSURES)(same)["flip_hdr"] == 0.0


def test_method_without_radiance_has_no_value_on_it(pictures):
    assert math.isnan(FLIPHDR(**EXPOSURES)(moment(*pictures))["flip_hdr"])


@pytest.mark.parametrize("wrong", [{"number": 1}, {"start": 3}, {"stop": math.inf}, {"pixels_per_degree": 0.0}])
def test_invalid_arguments_of_the_tool_are_errors(wrong):
    with pytest.raises(UserError, match=str(next(iter(wrong.values())))):
        FLIPHDR(**{**EXPOSURES, **wrong})


def test_single_exposure_gives_zero_in_the_tool(pictures):
    """The reason why fewer than two are an error."""
    parameters = {"startExposure": 0.0, "stopExposure": 0.0, "numExposures": 1}
    images = [p.astype(np.float32) for p in pictures]
    assert flip_evaluator.evaluate(*images, "HDR", applyMagma=False, parameters=parameters)[1] == 0.0
