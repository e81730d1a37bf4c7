import math

import pytest
import torch
import torch.nn.functional as F

from supersampling.errors import UserError
from supersampling.ops.interpolate import check_cubic, sample_bicubic5, sample_bicubic9


def cubic_kernel(t, a):
    """Evaluate Keys 1981, eq 15, with the free parameter ``a``."""
    t = abs(t)
    if t <= 1.0:
        return (a + 2) * t**3 - (a + 3) * t**2 + 1
    return a * t**3 - 5 * a * t**2 + 8 * a * t - 4 * a if t < 2.0 else 0.0


def bicubic_by_loops(image, grid, a, drop_corners):
    _, c, height, width = image.shape
    result = torch.zeros(c, *grid.shape[:2], dtype=image.dtype)
    for i in range(grid.shape[0]):
        for j in range(grid.shape[1]):
            x = (grid[i, j, 0].item() + 1) * width / 2 - 0.5
            y = (grid[i, j, 1].item() + 1) * height / 2 - 0.5
            total = 0.0
            for dy in range(-1, 3):
                for dx in range(-1, 3):
                    if drop_corners and dx in (-1, 2) and dy in (-1, 2):
                        continue
                    column, row = math.floor(x) + dx, math.floor(y) + dy
                    weight = cubic_kernel(x - column, a) * cubic_kernel(y - row, a)
                    total += weight
                    row, column = min(max(row, 0), height - 1), min(max(column, 0), width - 1)
                    result[:, i, j] += weight * image[0, :, row, column]
            result[:, i, j] /= total
    return result


@pytest.mark.parametrize("a", [-0.75, -0.5, -1.0, 0.0])
@pytest.mark.parametrize(("height", "width"), [(5, 7), (1, 1)])
def test_bicubic_kernels_equal_the_loops(a, height, width):
    image = torch.rand(1, 2, height, width, dtype=torch.float64)
    grid = torch.rand(6, 5, 2, dtype=torch.float64) * 2.6 - 1.3
    nine, five = sample_bicubic9(image, grid[None], a)[0], sample_bicubic5(image, grid[None], a)[0]
    torch.testing.assert_close(nine, bicubic_by_loops(image, grid, a, drop_corners=False))
    torch.testing.assert_close(five, bicubic_by_loops(image, grid, a, drop_corners=True))


def test_nine_fetches_equal_grid_sample_at_its_parameter():
    image, grid = torch.rand(2, 4, 9, 11), torch.rand(2, 8, 8, 2) * 2.4 - 1.2
    result = sample_bicubic9(image, grid, -0.75 + 1e-9)
    torch.testing.assert_close(result, grid_sample(image, grid), rtol=0, atol=5e-6)


@pytest.mark.parametrize("size", [(9, 11), (1, 1), (2, 7)])
def test_gradient_of_cubic_kernel_equals_the_loops(size):
    image = torch.rand(2, 3, *size, requires_grad=True)
    grid = torch.rand(2, 8, 6, 2) * 2.6 - 1.3
    # Far outside: the border pixel, or NaN.
    grid[0, 0, 0], grid[0, 0, 1] = 1e30, -torch.inf
    grid[1, 1, 1] = torch.tensor([1.0, -1.0])
    result = sample_bicubic9(image, grid, -0.75)
    assert torch.equal(result.nan_to_num(), grid_sample(image, grid).nan_to_num())

    finite = grid.abs() < 1e3
    grid = torch.where(finite, grid, 1.0)
    grad = torch.randn(2, 3, 8, 6)
    (gradient,) = torch.autograd.grad(sample_bicubic9(image, grid, -0.75), image, grad)
    exact = image.detach().double().requires_grad_()
    by_loops = torch.stack(
        [bicubic_by_loops(exact[k : k + 1], grid[k].double(), -0.75, drop_corners=False) for k in range(2)]
    )
    (expected,) = torch.autograd.grad(by_loops, exact, grad.double())
    torch.testing.assert_close(gradient, expected.float(), rtol=1e-4, atol=2e-5)


def test_positions_that_are_not_finite_do_not_corrupt_memory():
    image = torch.rand(1, 1, 4, 4, requires_grad=True)
    grid = torch.tensor([float("nan"), float("inf"), -1e38, 0.0]).view(1, 1, 2, 2)
    sample_bicubic9(image, grid, -0.75).sum().backward()
    assert image.grad is not None


def grid_sample(image, grid):
    return F.grid_sample(image, grid, mode="bicubic", padding_mode="border", align_corners=False)


@pytest.mark.parametrize("a", [0.5, -1.5, float("nan")])
def test_cubic_parameter_out_of_range_is_rejected(a):
    with pytest.raises(UserError, match=str(a)):
        check_cubic(a)
