import math

import pytest
import torch

from supersampling.errors import UserError
from supersampling.stages.reproject import Bicubic5, Bicubic9, Bilinear

OPTIONS = {
    "bilinear": Bilinear(),
    "bicubic5": Bicubic5(),
    "bicubic9": Bicubic9(),
    "bicubic5_a50": Bicubic5(-0.5),
    "bicubic9_a50": Bicubic9(-0.5),
}


def kernel(name, t):
    t = abs(t)
    if name == "bilinear":
        return max(1.0 - t, 0.0)
    a = -0.5 if name.endswith("a50") else -0.75
    if t <= 1.0:
        return (a + 2) * t**3 - (a + 3) * t**2 + 1
    return a * (t**3 - 5 * t**2 + 8 * t - 4) if t < 2.0 else 0.0


def reproject_by_loops(name, history, motion):
    _, c, height, width = history.shape
    result = torch.zeros_like(history)
    for i in range(height):
        for j in range(width):
            x, y = j + motion[0, 0, i, j].item() * width, i + motion[0, 1, i, j].item() * height
            total, value = 0.0, torch.zeros(c, dtype=history.dtype)
            for row in range(math.floor(y) - 1, math.floor(y) + 3):
                for column in range(math.floor(x) - 1, math.floor(x) + 3):
                    corner = abs(row - math.floor(y) - 0.5) > 1 and abs(column - math.floor(x) - 0.5) > 1
                    if corner and "bicubic5" in name:
                        continue
                    weight = kernel(name, x - column) * kernel(name, y - row)
                    total += weight
                    value += weight * history[0, :, min(max(row, 0), height - 1), min(max(column, 0), width - 1)]
            result[0, :, i, j] = value / total
    return result


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize(("height", "width"), [(6, 9), (1, 1), (1, 5)])
def test_equals_the_loops_for_any_motion(name, height, width):
    torch.manual_seed(1)
    history = torch.rand(1, 4, height, width, dtype=torch.float64)
    motion = torch.randn(1, 2, height, width, dtype=torch.float64) * 0.3
    torch.testing.assert_close(OPTIONS[name](history, motion), reproject_by_loops(name, history, motion))


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize(("height", "width"), [(1, 1), (9, 17), (270, 481)])
def test_zero_motion_is_the_exact_identity(name, height, width):
    history = torch.rand(2, 4, height, width)
    assert torch.equal(OPTIONS[name](history, torch.zeros(2, 2, height, width)), history)


@pytest.mark.parametrize("name", OPTIONS)
def test_gradient_reaches_the_history_through_still_and_moving_pixels(name):
    history = torch.rand(1, 2, 4, 4, dtype=torch.float64, requires_grad=True)
    motion = torch.full((1, 2, 4, 4), 0.1, dtype=torch.float64)
    motion[..., :2] = 0.0
    assert torch.autograd.gradcheck(lambda h: OPTIONS[name](h, motion), history)


@pytest.mark.parametrize("option", [Bicubic5, Bicubic9])
def test_invalid_kernel_parameter_raises(option):
    with pytest.raises(UserError, match=r"0\.75"):
        option(0.75)
