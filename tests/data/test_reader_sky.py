"""The unit of depth and the marks of the sky, recognised by their values."""

from pathlib import Path

import numpy as np
import pytest

from supersampling.data.readers.sky import measure_depth
from supersampling.errors import UserError

NEAR = np.linspace(0.5, 80.0, 600, dtype=np.float32).reshape(20, 30, 1)


def files(*frames):
    return [(Path("Depth") / f"{k}.exr", frame.astype(np.float32)) for k, frame in enumerate(frames)]


def with_sky(mark, depth=NEAR):
    depth = depth.copy()
    depth[:4] = mark
    return depth


@pytest.mark.parametrize("mark", [np.inf, 3.4028235e38, 1e30, 1e10, 1e9, 65535.0, 65504.0, 20000.0, -1.0, -1e10, 0.0])
def test_mark_becomes_the_far_end_and_surfaces_keep_their_range(mark):
    scale = measure_depth(files(NEAR, with_sky(mark)), False)
    assert scale.unit == 100.0
    assert scale.marks == {float(np.float32(mark))}
    assert scale.share == pytest.approx(120 / 1200)
    depth = scale.decode(with_sky(mark), False)
    assert (depth[:4] == 1.0).all()
    np.testing.assert_array_equal(depth[4:], NEAR[4:] / np.float32(100.0))


@pytest.mark.parametrize("mark", [np.inf, 1e10, 65504.0, -1.0])
def test_mark_beside_depth_in_unit_range(mark):
    unit = NEAR / np.float32(100.0)
    scale = measure_depth(files(with_sky(mark, unit)), False)
    assert scale.unit == 1.0
    np.testing.assert_array_equal(scale.decode(with_sky(mark, unit), False)[4:], unit[4:])
    assert (scale.decode(with_sky(mark, unit), True)[:4] == 1.0).all()


def test_zero_in_unit_range_is_a_depth():
    """Where depth is reversed, this is the sky, which the check of the direction reports."""
    scale = measure_depth(files(with_sky(0.0, NEAR / 100.0)), False)
    assert not scale.marks
    assert (scale.decode(with_sky(0.0, NEAR / 100.0), True)[:4] == 1.0).all()


@pytest.mark.parametrize("far", [100.0, 1000.0, 5000.0])
def test_far_plane_within_reach_is_a_distance(far):
    scale = measure_depth(files(with_sky(far)), False)
    assert (scale.unit, scale.marks) == (10.0 ** np.ceil(np.log10(far)), frozenset())


def test_two_marks_and_a_later_frame_with_the_largest_distance():
    later = with_sky(1e10, NEAR * 5.0)
    later[5] = np.inf
    scale = measure_depth(files(NEAR, later), False)
    assert (scale.unit, scale.marks) == (1000.0, {np.inf, 1e10})
    assert "captured depth is divided by 1000; 1e+10 and inf (12.5% of the pixels) count as sky" in scale.summary()


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (-NEAR, r"0\.exr has negative depths, down to -80"),
        (np.full_like(NEAR, 1e10), "shows no surface, only 1e"),
        (np.full_like(NEAR, np.inf), "shows no surface, only inf"),
    ],
)
def test_depth_without_meaning_is_an_error(frame, message):
    with pytest.raises(UserError, match=message):
        measure_depth(files(frame), False)


def test_sky_averaged_with_surfaces_is_an_error():
    large = np.tile(NEAR, (10, 10, 1))
    depth = with_sky(1e10, large)
    depth[4, :40] = np.linspace(1e5, 9e8, 40, dtype=np.float32)[:, None]
    with pytest.raises(UserError, match="averaged with the sky, export depth without a filter"):
        measure_depth(files(depth), False)
