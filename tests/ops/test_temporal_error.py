import torch

from supersampling.ops.temporal import carry_error, spatiotemporal_error


def test_error_equals_equation_54():
    x, y = torch.randn(100, dtype=torch.float64), torch.randn(100, dtype=torch.float64)
    for theta in (0.0, 0.1, 0.5, 1.0):
        expected = x.abs() + y.abs() + theta * ((x - y).abs() - x.abs() - y.abs())
        torch.testing.assert_close(spatiotemporal_error(x, y, theta), expected)


def test_error_follows_the_low_resolution_motion():
    error = torch.zeros(1, 1, 8, 8)
    error[..., 3, 5] = 1.0
    motion = torch.zeros(1, 2, 4, 4)
    # The pixel was two target pixels to the right.
    motion[:, 0] = 2 / 8
    warped = carry_error(error, motion)
    assert warped[0, 0, 3, 3] == 1.0
    assert warped.sum() == 1.0


def test_nan_motion_gives_a_finite_error_and_gradient():
    """PyTorch's gradient of a warp by NaN writes outside of memory."""
    error = torch.rand(1, 3, 8, 8, requires_grad=True)
    motion = torch.zeros(1, 2, 4, 4)
    motion[..., 1, 2] = torch.nan
    warped = carry_error(error, motion)
    (gradient,) = torch.autograd.grad(warped.sum(), error)
    assert warped.isfinite().all()
    assert gradient.isfinite().all()
    # The weights of a warp sum to 1.
    assert gradient.sum().item() == 192
