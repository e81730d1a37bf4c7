"""Pictures that hold nothing, that show something else than the targets, or that are in other units."""

import re

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from capture_files import JITTER, frame
from rendered import Rendered, unchanged

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.jitter_check import check_jitter
from supersampling.data.readers.pairs import Pair
from supersampling.data.readers.picture_check import check_pictures
from supersampling.data.readers.units import checked_light, checked_motion, checked_normal
from supersampling.errors import UserError

COLOURS = frozenset({"color", "depth", "motion", "jitter", "target"})
LIGHT = frozenset({"radiance", "normal", "high_material", "high_emission", "target_radiance", "target", "motion_dual"})


def pairs(change):
    return [Pair(Rendered(change), t, 1.0) for t in (1, 2, 3)]


def check(change, buffers=COLOURS):
    return check_pictures("here", pairs(change), buffers, False)


def edit(name, value):
    def change(buffers, t):
        buffers[name] = value(buffers[name]).astype(np.float32)

    return change


def enlarge(mode):
    def change(buffers, t):
        small = torch.from_numpy(buffers["color"].transpose(2, 0, 1))[None]
        buffers["target"] = F.interpolate(small, (64, 96), mode=mode)[0].numpy().transpose(1, 2, 0)

    return change


def test_correct_pictures_give_only_their_ranges():
    assert check(unchanged).startswith("here: as read, color 0.1")
    assert check(unchanged).count("\n") == 0
    assert check(unchanged, frozenset({"color", "radiance", "target", "target_radiance"})).count("\n") == 0


@pytest.mark.parametrize("name", ["color", "depth", "target"])
@pytest.mark.parametrize("value", [0.0, 0.5])
def test_empty_buffer_is_an_error(name, value):
    with pytest.raises(UserError, match=f"{name} is {value:g} in every pixel of the 3 .* recorder wrote nothing"):
        check(edit(name, lambda image: np.full_like(image, value)))


@pytest.mark.parametrize("name", ["radiance", "normal", "high_material", "target_radiance"])
def test_empty_light_is_an_error(name):
    with pytest.raises(UserError, match=f"{name} is 0 in every pixel"):
        check(edit(name, np.zeros_like), LIGHT)


def test_inverted_inputs_are_an_error():
    with pytest.raises(UserError, match="the inputs show the opposite of the targets"):
        check(edit("color", lambda image: 1.0 - image))


@pytest.mark.parametrize(
    ("change", "buffers", "line"),
    [
        (edit("color", lambda image: 0.5 * image), COLOURS, "the inputs are 0.5 times as bright as the targets"),
        (edit("target", lambda image: 0.7 * image), COLOURS, "the inputs are 1.4.* times as bright as the targets"),
        (edit("radiance", lambda image: 0.2 * image), LIGHT, "times as bright as the targets"),
        (edit("color", lambda image: image[::-1, ::-1]), COLOURS, "the inputs hardly show what the targets show"),
        (edit("target_radiance", lambda image: 4.0 * image), LIGHT, "differs from View_PNG by up to 0"),
        (unchanged, LIGHT | {"motion"}, "dual motion .OCMV. differs from motion .MV. in up to 100%"),
        (enlarge("nearest"), COLOURS, r"the targets are the inputs, enlarged \(nearest\)"),
        (enlarge("bilinear"), COLOURS, r"the targets are the inputs, enlarged \(bilinear\)"),
        (
            edit("target_radiance", lambda image: np.minimum(image, 0.9)),
            frozenset({"color", "target", "radiance", "target_radiance"}),
            "no radiance exceeds 0.9: check that the images are linear",
        ),
    ],
)
def test_doubtful_pictures_are_named(change, buffers, line):
    assert re.search(line, check(change, buffers))


def test_motion_of_two_resolutions_that_differ_is_an_error():
    with pytest.raises(UserError, match="motion in high and in low resolution differ in 100.0% of the pixels"):
        check(edit("high_motion", lambda motion: -motion), COLOURS | {"high_motion"})


def test_a_small_object_that_moves_in_one_resolution_only_is_named():
    lines = check(edit("high_motion", lambda motion: motion[::-1]), COLOURS | {"high_motion"})
    assert re.search(r"differ in \d+(\.\d+)?% of the pixels of a frame, away from edges", lines)
    assert "away from edges" not in check(lambda buffers, t: None, COLOURS | {"high_motion"})


def jitter(value):
    def change(buffers, t):
        buffers["jitter"] = value(t)

    return change


@pytest.mark.parametrize(
    "value",
    [
        lambda t: np.zeros(2, np.float32),
        lambda t: JITTER[t % 4] * 2.0 / np.array((48, 32), np.float32),
        lambda t: JITTER[(t + 1) % 4],
    ],
)
def test_jitter_of_another_unit_or_frame_is_an_error_that_the_user_may_override(value):
    with pytest.raises(UserError, match="sampled elsewhere than their jitter says"):
        check_jitter("here", pairs(jitter(value)), Convention("xy"), False)
    assert check_jitter("here", pairs(jitter(value)), Convention("xy"), True)


def test_inputs_without_jitter_may_say_so():
    def change(buffers, t):
        buffers |= {"color": frame(t, 0, 2, np.zeros(2, np.float32), 1.0)["color"].astype(np.float32)}
        buffers["jitter"] = np.zeros(2, np.float32)

    assert check_jitter("here", pairs(change), Convention("xy"), False)


MOTION = np.random.default_rng(0).uniform(-0.02, 0.02, (20, 30, 2)).astype(np.float32)
MARKED = np.where(np.arange(30)[None, :, None] < 5, np.float32(-1.0), MOTION)


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        (0.5 + 0.4 * MOTION, "unsigned encoding where 0.5 is no motion"),
        (np.round((0.5 + 0.4 * MOTION) * 255.0) / 255.0, "unsigned encoding where 0.5 is no motion"),
        (MARKED, r"exactly \(-1, -1\) in 16.7% of the pixels, which seems to mark pixels without motion"),
        (np.where(MARKED == -1.0, np.float32(65504.0), MARKED), r"exactly \(6.55e\+04, 6.55e\+04\) in 16.7%"),
        (MOTION * 500.0, "seems to be in pixels"),
    ],
)
def test_encoded_motion_is_an_error(tmp_path, motion, message):
    with pytest.raises(UserError, match=message):
        checked_motion(motion, tmp_path / "0001.exr")


def test_plain_motion_is_kept(tmp_path):
    assert checked_motion(MOTION, tmp_path) is MOTION


NORMAL = np.array([[[0.6, 0.0, 0.8], [0.0, -0.28, 0.96], [0.0, 0.0, 0.0]]], np.float32)


@pytest.mark.parametrize(
    ("normal", "message"),
    [
        (0.5 * NORMAL + 0.5, r"stored as \(n \+ 1\) / 2"),
        (127.0 * NORMAL, "components of up to 121.9: write unit vectors"),
    ],
)
def test_encoded_normals_are_an_error(tmp_path, normal, message):
    with pytest.raises(UserError, match=message):
        checked_normal(normal, tmp_path / "0001.exr")
    assert checked_normal(NORMAL, tmp_path) is NORMAL
    assert checked_normal(np.abs(NORMAL), tmp_path) is not None


def test_negative_light_is_an_error_and_ringing_is_not(tmp_path):
    light = np.linspace(0.0, 2.0, 30, dtype=np.float32).reshape(1, 10, 3)
    np.testing.assert_array_equal(
        checked_light(light - np.float32(1e-4), tmp_path), np.maximum(light - np.float32(1e-4), 0)
    )
    with pytest.raises(UserError, match="has 29 negative values, down to -2"):
        checked_light(-light, tmp_path / "0001.exr")
