import torch

from supersampling.ops.temporal import carry_error, spatiotemporal_error


def test_the_error_equals_equation_54():
    x, y = torch.randn(100, dtype=torch.float64), torch.randn(100, dtype=torch.float64)
    for theta in (0.0, 0.1, 0.5, 1.0):
        expected = x.abs() + y.abs() + theta * ((x - y).abs() - x.abs() - y.abs())
        torch.testing.assert_close(spatiotemporal_error(x, y, theta), expected)


def test_an_error_follows_the_low_resolution_motion():
    error = torch.zeros(1, 1, 8, 8)
    error[..., 3, 5] = 1.0
    motion = torch.zeros(1, 2, 4, 4)
    motion[:, 0] = 2 / 8  # where the pixel was: two target pixels to the right
    carried = carry_error(error, motion)
    assert carried[0, 0, 3, 3] == 1.0
    assert carried.sum() == 1.0
