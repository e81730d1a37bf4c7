import math

import pytest
import torch

from supersampling.ops.warp import broken_pixels, finite_motion, outside, sampling_grid, warp


def ramp(height, width):
    x = torch.arange(width, dtype=torch.float64) + 0.5
    y = torch.arange(height, dtype=torch.float64)[:, None] + 0.5
    return (0.2 * x + 0.7 * y).expand(1, 1, height, width)


def test_warp_moves_a_ramp_by_the_motion():
    height, width, shift = 12, 16, (1.75, -2.5)  # pixels
    motion = torch.tensor([shift[0] / width, shift[1] / height], dtype=torch.float64)
    moved = warp(ramp(height, width), motion.view(1, 2, 1, 1).expand(1, 2, height, width))
    expected = ramp(height, width) + 0.2 * shift[0] + 0.7 * shift[1]
    torch.testing.assert_close(moved[..., 3:-2, 2:-2], expected[..., 3:-2, 2:-2])


def test_integer_motion_copies_pixels():
    image = torch.rand(2, 3, 6, 8)
    motion = torch.tensor([[2 / 8, 1 / 6], [-3 / 8, 0.0]]).view(2, 2, 1, 1).expand(2, 2, 6, 8)
    moved = warp(image, motion)
    torch.testing.assert_close(moved[0, :, :5, :6], image[0, :, 1:, 2:], rtol=0, atol=1e-6)
    torch.testing.assert_close(moved[1, :, :, 3:], image[1, :, :, :5], rtol=0, atol=1e-6)


@pytest.mark.parametrize(("height", "width"), [(1, 1), (7, 13), (270, 481), (64, 64)])
def test_zero_motion_copies_exactly_and_small_motion_barely_blurs(height, width):
    image = torch.rand(1, 2, height, width)
    still = torch.zeros(1, 2, height, width)
    assert torch.equal(warp(image, still), image)
    torch.testing.assert_close(warp(image, still + 1e-12), image, rtol=0, atol=1e-4)


def test_outside_marks_previous_positions_beyond_the_image():
    motion = torch.zeros(1, 2, 4, 8)
    assert not outside(motion).any()
    # Three pixels to the right.
    motion[:, 0] = 3.0 / 8
    expected = torch.zeros(4, 8, dtype=torch.bool)
    expected[:, 5:] = True
    assert torch.equal(outside(motion)[0, 0], expected)
    motion[:, 1] = -1.0 / 4
    expected[0] = True
    assert torch.equal(outside(motion)[0, 0], expected)


def test_grid_without_motion_equals_affine_grid():
    theta = torch.tensor([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]], dtype=torch.float64)
    expected = torch.nn.functional.affine_grid(theta, [1, 1, 5, 9], align_corners=False)
    torch.testing.assert_close(sampling_grid(torch.zeros(1, 2, 5, 9, dtype=torch.float64)), expected)


def test_positions_on_the_border_are_inside_in_every_precision():
    """Half a pixel of motion leads from the last pixel's centre to the border, where rounding depends on the width."""
    for width in range(1, 200):
        motion = torch.zeros(1, 2, 1, width, dtype=torch.float64)
        motion[:, 0] = 0.5 / width
        assert not outside(motion).any()
        assert not outside(motion.float()).any()
        assert outside(motion.float() * 1.01)[..., -1].all()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_motion_that_is_not_finite_is_repaired_and_stays_outside(value):
    motion = torch.zeros(1, 2, 4, 8)
    motion[0, 1, 2, 3] = value
    expected = torch.zeros(1, 1, 4, 8, dtype=torch.bool)
    expected[0, 0, 2, 3] = True
    assert torch.equal(outside(motion), expected)
    repaired = finite_motion(motion)
    assert repaired.isfinite().all()
    assert torch.equal(outside(repaired), expected)
    assert torch.equal(repaired[motion.isfinite()], motion[motion.isfinite()])


def test_history_is_broken_where_any_channel_is():
    history = torch.rand(1, 3, 4, 8)
    for k, (channel, value) in enumerate(((0, math.nan), (1, math.inf), (2, -math.inf), (0, 1e5))):
        history[0, channel, k, k] = value
    expected = torch.zeros(4, 8, dtype=torch.bool)
    expected[range(4), range(4)] = True
    assert torch.equal(broken_pixels(history)[0, 0], expected)
