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


def test_motion_that_is_nan_leaves_a_finite_error_and_gradient():
    """PyTorch's gradient of a warp by NaN writes outside of memory."""
    error = torch.rand(1, 3, 8, 8, requires_grad=True)
    motion = torch.zeros(1, 2, 4, 4)
    motion[..., 1, 2] = torch.nan
    carried = carry_error(error, motion)
    (gradient,) = torch.autograd.grad(carried.sum(), error)
    assert carried.isfinite().all()
    assert gradient.isfinite().all()
    assert gradient.sum().item() == 192  # a warp's weights sum to 1
