import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter

from supersampling.ops.window import gaussian_mean


@pytest.mark.parametrize(("window", "sigma", "shape"), [(11, 1.5, (2, 3, 14, 17)), (5, 0.8, (6, 5)), (1, 1.0, (2, 2))])
def test_mean_equals_scipy_in_full_windows(window, sigma, shape):
    maps = np.random.default_rng(0).normal(size=shape)
    r = window // 2
    filtered = gaussian_filter(maps, sigma, radius=r, axes=(-2, -1))
    expected = filtered[..., r : shape[-2] - r, r : shape[-1] - r]
    np.testing.assert_allclose(gaussian_mean(torch.from_numpy(maps), window, sigma).numpy(), expected, rtol=1e-12)


def test_derivatives():
    torch.manual_seed(0)
    maps = torch.randn(2, 6, 7, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: gaussian_mean(x, 5, 1.5), (maps,))
    assert torch.autograd.gradgradcheck(lambda x: gaussian_mean(x, 5, 1.5).square(), (maps,))
