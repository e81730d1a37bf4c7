import numpy as np
import pytest
import torch
from skimage.metrics import structural_similarity

from supersampling.errors import UserError
from supersampling.losses import SSIM


def clip(seed, scale=1.0, shape=(2, 2, 3, 19, 23)):
    """Return smooth patterns with noise, so that windows differ in mean, contrast and correlation."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: shape[-2], : shape[-1]]
    return scale * (0.5 + 0.3 * np.sin(0.3 * x + 0.2 * y + seed) + 0.1 * rng.normal(size=shape))


@pytest.mark.parametrize(("scale", "data_range"), [(1.0, 1.0), (30.0, 1.0), (30.0, 100.0)])
def test_loss_is_one_minus_the_ssim_of_scikit_image(scale, data_range):
    x, y = clip(0, scale), clip(1, scale)
    settings = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False, "channel_axis": 0}
    ssim = [
        structural_similarity(a, b, data_range=data_range, **settings)
        for a, b in zip(x.reshape(-1, 3, 19, 23), y.reshape(-1, 3, 19, 23))
    ]
    loss = SSIM(data_range)
    assert loss(torch.from_numpy(x), torch.from_numpy(y), {}).item() == pytest.approx(1.0 - np.mean(ssim), rel=1e-9)
    assert (loss.requires, loss.previous) == (frozenset(), 0)


def test_small_error_is_exact_in_single_precision():
    """Subtracting an SSIM near 1 from 1 would lose a loss near 0 to rounding."""
    y = clip(0)
    x = y + 1e-4 * np.random.default_rng(2).normal(size=y.shape)
    exact = SSIM(1.0)(torch.from_numpy(x), torch.from_numpy(y), {}).item()
    rounded = SSIM(1.0)(torch.from_numpy(x).float(), torch.from_numpy(y).float(), {}).item()
    assert 0.0 < exact < 1e-5
    assert rounded == pytest.approx(exact, rel=0.02)


def test_equal_images_cost_nothing_and_have_no_gradient():
    y = torch.from_numpy(clip(0)).float()
    x = y.clone().requires_grad_()
    loss = SSIM(1.0)(x, y, {})
    loss.backward()
    assert loss.item() == 0.0
    assert torch.equal(x.grad, torch.zeros_like(x))


@pytest.mark.parametrize("level", [0.0, 1.0, 1e3, 6.5e4])
def test_loss_stays_in_range_with_finite_gradients_at_any_brightness(level):
    torch.manual_seed(0)
    y = torch.full((1, 1, 3, 16, 16), level) * (1.0 + 1e-7 * torch.randn(1, 1, 3, 16, 16))
    for error in (torch.zeros(()), torch.full((), 1e-3), 0.1 * level * torch.randn_like(y), -2.0 * y):
        x = (y + error).requires_grad_()
        loss = SSIM(1.0)(x, y, {})
        loss.backward()
        assert 0.0 <= loss.item() <= 2.0 + 1e-6
        assert x.grad.isfinite().all()


def test_gradient():
    torch.manual_seed(0)
    x, y = torch.rand(2, 1, 1, 1, 12, 13, dtype=torch.float64)
    assert torch.autograd.gradcheck(lambda x: SSIM(1.0)(x, y, {}), (x.requires_grad_(),))


def test_half_precision_is_summed_in_single_precision():
    x, y = torch.from_numpy(clip(0)).bfloat16(), torch.from_numpy(clip(1)).float()
    assert SSIM(1.0)(x, y, {}).dtype == torch.float32


def test_invalid_crops_and_ranges_are_rejected():
    small = torch.zeros(1, 1, 3, 10, 20)
    with pytest.raises(UserError, match="20x10"):
        SSIM(1.0)(small, small, {})
    with pytest.raises(UserError, match="Invalid data_range=0"):
        SSIM(0.0)
