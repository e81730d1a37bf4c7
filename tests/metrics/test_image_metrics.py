from pathlib import Path

import numpy as np
import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from supersampling.errors import UserError
from supersampling.metrics.base import Moment
from supersampling.metrics.image import PSNR_CAP, psnr, ssim_gauss11, ssim_uniform11, ssim_zero_pad11
from supersampling.metrics.prepare import HIGHEST_RADIANCE, Continuous, EightBit, bounded
from supersampling.metrics.radiance import PSNRMu, psnr_hdr_mu
from supersampling.metrics.regions import Regions
from supersampling.metrics.still import PSNR, SSIM, SSIMUniform11, SSIMZeroPad11
from supersampling.metrics.video.static import StaticDeviation

SSIMS = (ssim_gauss11, ssim_uniform11, ssim_zero_pad11)


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


@pytest.mark.parametrize(("dtype", "tolerance"), [(torch.float64, 1e-6), (torch.float32, 1e-5)])
def test_uniform_ssim_equals_skimage_as_nsrd_calls_it(pair, dtype, tolerance):
    bytes_of = [np.round(255 * image.transpose(1, 2, 0)).astype(np.uint8) for image in pair]
    expected = structural_similarity(*bytes_of, win_size=11, channel_axis=2, data_range=255)
    output, target = tensors(pair, dtype)
    output, target = (EightBit()(image, image) for image in (output, target))
    assert ssim_uniform11(output, target).item() == pytest.approx(expected, abs=tolerance)
    assert abs(ssim_gauss11(output, target).item() - expected) > 0.01


def ssim_of_loops(output, target):
    """Equations 14 to 17 of the thesis, ``C3 = C2 / 2``, at each pixel of each channel; zeros outside the image."""
    g = np.exp(-0.5 * ((np.arange(11) - 5) / 1.5) ** 2)
    w, c1, c2 = np.outer(g, g) / g.sum() ** 2, 0.01**2, 0.03**2
    values = []
    for x, y in zip(output, target):
        x, y = np.pad(x, 5), np.pad(y, 5)
        for row, column in np.ndindex(x.shape[0] - 10, x.shape[1] - 10):
            p, q = (image[row : row + 11, column : column + 11] for image in (x, y))
            mp, mq = (w * p).sum(), (w * q).sum()
            sp, sq = np.sqrt((w * (p - mp) ** 2).sum()), np.sqrt((w * (q - mq) ** 2).sum())
            covariance = (w * (p - mp) * (q - mq)).sum()
            luminance = (2 * mp * mq + c1) / (mp**2 + mq**2 + c1)
            contrast = (2 * sp * sq + c2) / (sp**2 + sq**2 + c2)
            values.append(luminance * contrast * (covariance + c2 / 2) / (sp * sq + c2 / 2))
    return np.mean(values)


@pytest.mark.parametrize("size", [(9, 16), (23, 14)])  # one smaller than a window
def test_zero_padded_ssim_equals_loops(pair, size):
    output, target = (np.ascontiguousarray(image[:, : size[0], 12 : 12 + size[1]]) for image in pair)
    result = ssim_zero_pad11(*tensors((output, target), torch.float64)).item()
    assert result == pytest.approx(ssim_of_loops(output, target), abs=1e-10)


def test_border_tells_the_two_gaussian_ssims_apart(pair):
    output, target = tensors(pair, torch.float64)
    assert abs(ssim_zero_pad11(output, target) - ssim_gauss11(output, target)) > 1e-3
    middle = (..., slice(10, 30), slice(10, 43))
    changed = output.clone()
    changed[..., :2, :] = 0.5
    assert ssim_gauss11(changed[middle], target[middle]) == ssim_gauss11(output[middle], target[middle])
    assert ssim_zero_pad11(changed, target) < ssim_zero_pad11(output, target)


@pytest.mark.parametrize("ssim", SSIMS)
def test_identical_images_score_one(pair, ssim):
    _, target = tensors(pair, torch.float32)
    assert ssim(target, target).item() == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("ssim", [ssim_gauss11, ssim_uniform11])
def test_image_smaller_than_the_window_is_error(ssim):
    assert ssim(torch.zeros(1, 3, 11, 11), torch.zeros(1, 3, 11, 11)).item() == pytest.approx(1.0)
    with pytest.raises(UserError, match="12x10"):
        ssim(torch.zeros(1, 3, 10, 12), torch.zeros(1, 3, 10, 12))


@pytest.mark.parametrize("ssim", SSIMS)
def test_black_frames(ssim):
    """Black against black is identical; against flat grey only the luminance term remains, but for the border that
    zeros outside the image make of it."""
    black, grey = torch.zeros(1, 3, 16, 16), torch.full((1, 3, 16, 16), 0.5)
    assert psnr(black, black).item() == PSNR_CAP
    assert psnr(black, grey).item() == pytest.approx(20 * np.log10(2), abs=1e-5)
    assert ssim(black, black).item() == pytest.approx(1.0, abs=1e-6)
    if ssim is not ssim_zero_pad11:
        assert ssim(black, grey).item() == pytest.approx(1e-4 / (0.25 + 1e-4), abs=1e-5)


@pytest.mark.parametrize("broken", [float("nan"), float("inf"), -float("inf")])
@pytest.mark.parametrize("highest", [1.0, HIGHEST_RADIANCE])
def test_broken_value_costs_the_maximum(broken, highest):
    target = highest * torch.linspace(0, 1, 101)
    error = (bounded(torch.full_like(target, broken), target, highest) - target).abs()
    assert torch.equal(error, torch.maximum(target, highest - target))


def test_values_out_of_range_are_clamped():
    output = torch.tensor([-0.1, 0.0, 0.3, 1.0, 1.2])
    assert Continuous()(output, torch.zeros(5)).tolist() == pytest.approx([0, 0, 0.3, 1, 1])
    assert bounded(output, torch.zeros(5), HIGHEST_RADIANCE).tolist() == pytest.approx([0, 0, 0.3, 1, 1.2])


def test_broken_frame_counts_and_scores_worst(pair):
    output, target = tensors(pair, torch.float32)
    single, all_of_it = output.clone(), torch.full_like(output, float("nan"))
    single[..., 7, 9] = float("nan")
    assert psnr(single, target).isnan()  # unprepared, it would vanish from a mean
    for metric in (psnr, *SSIMS):
        values = [metric(Continuous()(image, target), target).item() for image in (output, single, all_of_it)]
        assert values[0] > values[1] > values[2]


def test_eight_bits_are_the_nearest_steps():
    values = 1.4 * torch.rand(500, dtype=torch.float64, generator=torch.Generator().manual_seed(0)) - 0.2
    steps = 255 * EightBit()(values, torch.zeros_like(values))
    nearest = [min(range(256), key=lambda k, v=v: abs(255 * v - k)) for v in values.tolist()]
    assert (steps - torch.tensor(nearest)).abs().max() < 1e-9


def test_values_within_half_a_step_become_identical():
    target = torch.randint(0, 256, (1, 3, 16, 16), generator=torch.Generator().manual_seed(0)).float() / 255.0
    near, far = target + 0.49 / 255, target - 0.51 / 255
    assert psnr(EightBit()(near, target), target).item() == PSNR_CAP
    assert psnr(near.clamp(0, 1), target).item() < 60
    assert psnr(EightBit()(far, target), target).item() == pytest.approx(20 * np.log10(255), abs=0.1)


def test_mu_law_psnr_by_hand():
    """White (2) against a hundredth of it, and against four times it, which is not clamped."""
    radiance = torch.tensor([0.02, 8.0]).view(2, 1, 1, 1).expand(2, 3, 4, 4)
    expected = [-20 * np.log10(abs(np.log(1 + 5000 * r) / np.log(5001) - 1)) for r in (0.01, 4.0)]
    assert psnr_hdr_mu(radiance, torch.full((2, 3, 4, 4), 2.0), white=2.0).tolist() == pytest.approx(expected, abs=1e-4)
    assert psnr_hdr_mu(-radiance, torch.zeros_like(radiance), white=2.0).tolist() == [PSNR_CAP] * 2


@pytest.mark.parametrize("white", [0.0, -1.0, float("inf"), float("nan")])
def test_invalid_white_is_error(white):
    with pytest.raises(UserError, match="white"):
        PSNRMu(white)


def test_each_metric_computes_its_function(pair):
    output, target = tensors(pair, torch.float32)
    moment = Moment(output=output, target=target, radiance=(4 * output, 4 * target))
    expected = {
        "psnr": psnr(output, target).item(),
        "ssim": ssim_gauss11(output, target).item(),
        "ssim_uniform11": ssim_uniform11(output, target).item(),
        "ssim_zero_pad11": ssim_zero_pad11(output, target).item(),
        "psnr_hdr_mu": psnr_hdr_mu(4 * output, 4 * target, 2.0).item(),
    }
    metrics = (PSNR(), SSIM(), SSIMUniform11(), SSIMZeroPad11(), PSNRMu(2.0))
    assert len(set(expected.values())) == len(expected)
    for metric, name in zip(metrics, expected):
        assert metric.names == (name,)
        assert metric(moment) == {name: expected[name]}


def test_radiance_metric_is_nan_without_radiance(pair):
    output, target = tensors(pair, torch.float32)
    assert np.isnan(PSNRMu(1.0)(Moment(output=output, target=target))["psnr_hdr_mu"])


WARPING = ("warping_error", "warping_error_reference", "warping_error_ratio")
REGIONS = set(Regions.names)
SINGLE = {"psnr", "ssim", "ssim_uniform11", "ssim_zero_pad11", "spatial", "temporal"}
CLIPS = {*StaticDeviation.names, "strred", "srred", "trred", "vmaf"}
PAPER = SINGLE | REGIONS | CLIPS | set(WARPING)
FOLDER = Path(__file__).parents[2] / "conf" / "metrics"
# What each has at least. Others are run as well, but for `lpips`, which raises without weights.
PRESETS = {path.stem: set() for path in sorted(FOLDER.glob("*.yaml")) if path.stem != "lpips"} | {
    "fast": {"psnr", "ssim"},
    "paper": PAPER,
    "capture": SINGLE | CLIPS | {name.replace("error", "error_photometric") for name in WARPING},
    "all": PAPER | {"flip", "lpips_alex", "cvvdp"},
    "hdr": {"psnr", "ssim", "flip", "psnr_hdr_mu", "flip_hdr"},
}


@pytest.mark.parametrize("name", PRESETS)
def test_presets(name):
    """Each preset computes at least these metrics, and reads their buffers; captures have no dual motion."""
    metrics = instantiate(OmegaConf.load(FOLDER / f"{name}.yaml"))
    buffers = {
        "target": True,
        "motion": "temporal" in PRESETS[name],
        "motion_dual": "psnr_disoccluded" in PRESETS[name],
        "target_radiance": "flip_hdr" in PRESETS[name],
    }
    assert metrics.requires >= {buffer for buffer, is_read in buffers.items() if is_read}
    assert name != "capture" or "motion_dual" not in metrics.requires
    targets = torch.rand(10, 1, 3, 48, 48, generator=torch.Generator().manual_seed(0))
    scores = {}
    with metrics.clips.begin() as clip:
        for t, target in enumerate(targets):
            output = (target + 0.1).clamp(0, 1)
            still = torch.zeros(1, 2, 12, 12)
            previous = (targets[t - 1], targets[t - 1]) if t else None
            moment = Moment(
                output=output,
                target=target,
                previous=previous,
                motion=still,
                motion_dual=still,
                radiance=(output, target),
                size=(12, 12),
            )
            scores.update(metrics.frames(moment))
            clip.add(moment)
        scores.update(clip.finish())
    assert PRESETS[name] <= scores.keys() == set(metrics.names)
    # LPIPS has no weights here; nothing moves, so that no pixel is moving or disoccluded.
    without = {"lpips_alex", "psnr_disoccluded", "psnr_moving"}
    assert all(np.isfinite(value) for metric, value in scores.items() if metric not in without)
