import numpy as np
import pytest
import torch
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from supersampling.errors import UserError
from supersampling.metrics.image import PSNR_CAP, mssim_thesis, psnr, ssim_gauss11


@pytest.fixture
def pair():
    """A smooth image with a flat part, and a noisy, shifted copy."""
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:40, 0:53] / 30.0
    target = np.stack([0.5 + 0.4 * np.sin(6 * x + c) * np.cos(5 * y) for c in range(3)])
    target[:, :20, :20] = 0.95
    output = np.clip(np.roll(target, 1, axis=2) + 0.05 * rng.standard_normal(target.shape), 0, 1)
    return output, target


def tensors(pair, dtype):
    return tuple(torch.from_numpy(image)[None].to(dtype) for image in pair)


def skimage_ssim(output, target, **constants):
    return structural_similarity(
        output,
        target,
        channel_axis=0,
        data_range=1.0,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        **constants,
    )


def test_psnr_equals_skimage_per_frame(pair):
    output, target = tensors(pair, torch.float64)
    batch = psnr(torch.cat((output, target * 0.9)), torch.cat((target, target)))
    expected = [peak_signal_noise_ratio(pair[1], image, data_range=1.0) for image in (pair[0], pair[1] * 0.9)]
    assert batch.tolist() == pytest.approx(expected)


def test_psnr_of_identical_images_is_the_cap(pair):
    _, target = tensors(pair, torch.float32)
    assert psnr(target, target).item() == PSNR_CAP


@pytest.mark.parametrize(("dtype", "tolerance"), [(torch.float64, 1e-6), (torch.float32, 1e-5)])
def test_ssim_equals_skimage(pair, dtype, tolerance):
    output, target = tensors(pair, dtype)
    assert ssim_gauss11(output, target).item() == pytest.approx(skimage_ssim(*pair), abs=tolerance)


def test_the_thesis_constant_is_skimages_k2_of_0_02(pair):
    output, target = tensors(pair, torch.float64)
    expected = skimage_ssim(*pair, K2=0.02)
    assert abs(expected - skimage_ssim(*pair)) > 1e-3
    assert mssim_thesis(output, target).item() == pytest.approx(expected, abs=1e-6)


def test_three_term_formula_of_the_thesis_collapses(pair):
    """Equation 17 written out with C3 = C2 / 2 for one window, the image's first."""
    x, y = (image[:1, :11, 30:41] for image in pair)
    g = np.exp(-0.5 * ((np.arange(11) - 5) / 1.5) ** 2)
    w = np.outer(g, g) / g.sum() ** 2
    mx, my = (w * x).sum(), (w * y).sum()
    sx, sy = np.sqrt((w * (x - mx) ** 2).sum()), np.sqrt((w * (y - my) ** 2).sum())
    sxy, c1, c2 = (w * (x - mx) * (y - my)).sum(), 0.01**2, 0.02**2
    terms = (
        (2 * mx * my + c1) / (mx**2 + my**2 + c1),
        (2 * sx * sy + c2) / (sx**2 + sy**2 + c2),
        (sxy + c2 / 2) / (sx * sy + c2 / 2),
    )
    result = mssim_thesis(torch.from_numpy(x)[None], torch.from_numpy(y)[None])
    assert result.item() == pytest.approx(np.prod(terms), abs=1e-10)


def test_identical_images_score_one(pair):
    _, target = tensors(pair, torch.float32)
    assert ssim_gauss11(target, target).item() == pytest.approx(1.0, abs=1e-6)


def test_an_image_smaller_than_the_window_is_refused():
    with pytest.raises(UserError, match="12x10"):
        ssim_gauss11(torch.zeros(1, 3, 10, 12), torch.zeros(1, 3, 10, 12))
