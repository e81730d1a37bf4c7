import pytest
import torch

from supersampling.ops.motion_mask import motion_mask


def test_both_axes_are_measured_in_low_resolution_pixels():
    torch.manual_seed(0)
    h, w = 5, 8
    offset = torch.rand(3, 2, 2 * h, 2 * w) * 0.06 - 0.03
    mask = motion_mask(offset, (h, w))
    assert mask.shape == (3, 1, 10, 16)
    for n in range(3):
        for i in range(10):
            for j in range(16):
                moved = abs(offset[n, 0, i, j].item()) * w >= 0.1 or abs(offset[n, 1, i, j].item()) * h >= 0.1
                assert mask[n, 0, i, j] == float(moved)
    assert 0.1 < mask.mean() < 0.9


@pytest.mark.parametrize(("pixels", "expected"), [(0.0, 0.0), (0.0999, 0.0), (0.1001, 1.0), (-0.1001, 1.0)])
@pytest.mark.parametrize("axis", [0, 1])
def test_threshold(axis, pixels, expected):
    offset = torch.zeros(1, 2, 3, 3)
    offset[0, axis] = pixels / 3
    assert (motion_mask(offset, (3, 3)) == expected).all()


def test_mask_has_the_type_of_its_input():
    assert motion_mask(torch.zeros(1, 2, 1, 1).double(), (1, 1)).dtype == torch.float64
