import pytest
import torch

from supersampling.metrics.temporal import spatial_loss, temporal_loss


def test_closed_form_for_constant_errors_of_each_frame():
    target, still = torch.full((2, 3, 8, 8), 0.5), torch.zeros(2, 2, 4, 4)
    now = torch.tensor([0.1, -0.2]).view(2, 1, 1, 1)
    before = torch.tensor([0.3, 0.05]).view(2, 1, 1, 1)
    frames = (target + now, target, target + before, target, still)
    assert spatial_loss(*frames).tolist() == pytest.approx([0.4, 0.25])
    assert temporal_loss(*frames).tolist() == pytest.approx([0.2, 0.25])


def test_error_that_moves_with_the_picture_is_no_flicker():
    error = torch.zeros(1, 3, 8, 16)
    error[..., 2:5, 6:9] = 0.4
    motion = torch.zeros(1, 2, 4, 8)
    motion[:, 0] = -2 / 16  # the picture moves two target pixels to the right
    target = torch.full_like(error, 0.3)
    moved = torch.roll(error, 2, dims=3)
    frames = (target + moved, target, target + error, target)
    assert temporal_loss(*frames, motion).item() == pytest.approx(0.0, abs=1e-7)
    flicker = 2 * 0.4 * 2 * 3 / (8 * 16)  # judged without motion: two columns of three pixels appear, two vanish
    assert temporal_loss(*frames, torch.zeros_like(motion)).item() == pytest.approx(flicker)
