"""Motion that is missing, incomplete or of another frame, and pictures that stand still while their light changes."""

import numpy as np
import pytest
from capture_files import JITTER, frame
from rendered import Rendered, unchanged

from supersampling.data.readers.conventions import Convention
from supersampling.data.readers.motion_check import check_motion
from supersampling.data.readers.pairs import select_pairs
from supersampling.errors import UserError


def check(change, speed=1.0, overridden=False):
    return check_motion("here", select_pairs([Rendered(change, speed)]), Convention("xy"), overridden)


def zero(where=lambda b, t: ...):
    def change(buffers, t):
        buffers["motion"][where(buffers, t)] = 0.0

    return change


def of_frame(step):
    def change(buffers, t):
        buffers["motion"] = frame(t + step, 0, 2, JITTER[(t + step) % 4], 1.0)["motion"].astype(np.float32)

    return change


def one_axis(axis):
    def change(buffers, t):
        buffers["motion"][..., axis] = 0.0

    return change


def every_second(buffers, t):
    if t % 2:
        buffers["motion"][:] = 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (zero(), "all motion is 0, so record the motion again"),
        (zero(lambda b, t: b["depth"][..., 0] > 0.3), "motion is 0 there, so record the camera's motion"),
        (every_second, "motion is 0 there, so record the camera's motion"),
        (one_axis(0), "the x component of all motion is 0"),
        (one_axis(1), "the y component of all motion is 0"),
        (of_frame(1), "the motion of the frame before fits better"),
        (of_frame(-1), "the motion of the frame after fits better"),
    ],
)
def test_wrong_motion_is_an_error_that_the_user_may_override(change, message):
    with pytest.raises(UserError, match=message):
        check(change)
    assert check(change, overridden=True)


@pytest.mark.parametrize("speed", [0.3, 0.5, 2.0])
def test_missing_motion_of_other_speeds(speed):
    with pytest.raises(UserError, match="all motion is 0"):
        check(zero(), speed)


def test_objects_without_motion_are_a_line():
    line = check(zero(lambda b, t: b["depth"][..., 0] < 0.3)).splitlines()[-1]
    assert "6% of the pictures (9% in clip, frame 3) move otherwise than recorded" in line
    assert "and that of animated objects" in line


def test_same_motion_in_every_pixel_is_a_line():
    def change(buffers, t):
        buffers["motion"][:] = buffers["motion"][-1, 0]

    assert "every pixel of a frame has the same motion" in check(change)


def flicker(buffers, t):
    buffers["target"] *= 0.6 if t % 2 else 1.0


def lamp(buffers, t):
    x = np.arange(buffers["target"].shape[1], dtype=np.float32)[None, :, None]
    buffers["target"] *= 0.5 + 0.5 * np.exp(-(((x - 20.0 * t) / 15.0) ** 2))


def noise(buffers, t):
    buffers["target"] += np.random.default_rng(t).normal(0.0, 0.05, buffers["target"].shape).astype(np.float32)


@pytest.mark.parametrize("change", [unchanged, flicker, lamp, noise])
def test_still_pictures_need_no_motion(change):
    assert "neither in the motion nor in the pictures" in check(change, speed=0.0)


@pytest.mark.parametrize("change", [unchanged, noise])
def test_correct_motion_leaves_nothing_to_explain(change):
    assert check(change).count("\n") == 0


def test_repeated_pictures_are_named():
    def change(buffers, t):
        if t == 3:
            buffers["target"] = frame(2, 0, 2, JITTER[2], 1.0)["target"].astype(np.float32)

    with pytest.raises(UserError, match=r"in clip, frame 3\) move otherwise .* seems to have dropped a frame"):
        check(change)
