"""Each metric detects its fault, and a stronger fault is worse; some metrics are blind to other faults."""

from itertools import pairwise

import pytest
import torch
from video_clips import blurred, flickering, ghosted, moments, noisy, pan, passing_square, score

from supersampling.metrics.image import psnr, ssim_gauss11
from supersampling.metrics.regions import Regions
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, WarpingError

COUNT = 8


@pytest.fixture(scope="module")
def film():
    """A pan whose reference is a little noisy, so that it has a warping error of its reference."""
    images, motions = pan(COUNT)
    return noisy(images, 0.01), motions


def mean(metric, outputs, targets):
    return torch.cat([metric(o, t) for o, t in zip(outputs, targets)]).mean().item()


def warping(outputs, targets, motions):
    return score(WarpingError(DualMotion()), outputs, targets, motions, motions)["warping_error"]


def regions(outputs, targets, motions, duals):
    values = [Regions()(m) for m in moments(outputs, targets, motions, duals)][1:]
    return {name: sum(v[name] for v in values) / len(values) for name in values[0]}


def worse(values):
    """Strictly rising, by more than rounding."""
    return all(b > a * 1.02 for a, b in pairwise(values))


def test_one_frames_flicker_is_seen_by_warping_error_and_not_by_mean_psnr(film):
    targets, motions = film
    constant = [t + 0.05 for t in targets]
    flicker = flickering(targets, 0.05)
    assert mean(psnr, flicker, targets) > mean(psnr, constant, targets)
    reference = warping(targets, targets, motions)
    assert warping(constant, targets, motions) == pytest.approx(reference, rel=1e-3)
    assert warping(flicker, targets, motions) > 2 * reference


def test_more_flicker_is_worse(film):
    targets, motions = film
    heights = (0.0, 0.02, 0.05, 0.1)
    assert worse([warping(flickering(targets, h), targets, motions) for h in heights])
    still = [targets[0]] * COUNT
    rest = [torch.zeros_like(motions[0])] * COUNT
    deviations = [score(StaticDeviation(), flickering(still, h), still, rest)["static_std"] for h in heights]
    assert deviations[0] == 0.0
    assert worse(deviations[1:])
    assert deviations[1] > 0.0


def test_ghost_trail_is_seen_where_the_square_was():
    targets, motions, duals = passing_square(COUNT)
    clean = noisy(targets, 0.01)
    trails = [regions(ghosted(clean, weight), targets, motions, duals) for weight in (0.0, 0.1, 0.2, 0.4)]
    hidden = [values["psnr_disoccluded"] for values in trails]
    assert hidden[0] > hidden[1] + 3 > hidden[2] + 6 > hidden[3] + 9
    assert 0.0 < trails[0]["fraction_disoccluded"] < 0.1
    assert trails[3]["psnr_elsewhere"] > trails[3]["psnr_disoccluded"] + 3


def test_shift_by_one_pixel_is_seen_by_image_metrics_and_not_by_warping_error(film):
    targets, motions = film
    shifted = [torch.roll(t, 1, dims=2) for t in targets]  # across the motion, so that nothing enters
    assert mean(psnr, shifted, targets) < mean(psnr, noisy(targets, 0.01), targets) - 6
    assert mean(ssim_gauss11, shifted, targets) < 0.95
    assert warping(shifted, targets, motions) == pytest.approx(warping(targets, targets, motions), rel=1e-3)


def test_wrong_tonemap_is_seen_by_psnr_and_not_by_warping_error(film):
    targets, motions = film
    mapped = [t.clamp_min(0.0) ** (1 / 1.3) for t in targets]
    assert mean(psnr, mapped, targets) < 28
    assert warping(mapped, targets, motions) < 2 * warping(targets, targets, motions)


def test_swapped_channels_are_seen_by_psnr_and_ssim(film):
    targets, _ = film
    swapped = [t.flip(1) for t in targets]
    assert mean(psnr, swapped, targets) < 20
    assert mean(ssim_gauss11, swapped, targets) < 0.8


def test_luma_metrics_are_blind_to_colour_of_equal_luma():
    """The reason for RGB metrics: red and blue are shifted against each other at constant luma."""
    targets, _ = pan(4)
    shift = torch.tensor([0.1, 0.0, -0.1 * 0.2126 / 0.0722])[:, None, None]
    targets = [0.4 + 0.2 * t for t in targets]
    tinted = [t + shift for t in targets]
    assert mean(psnr, tinted, targets) < 18
    assert score(StRred(), tinted, targets)["strred"] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("fault", ["blur", "noise"])
def test_more_blur_or_noise_is_worse_by_strred_and_vmaf(film, fault):
    targets, _ = film
    clips = {
        "blur": [blurred(targets, radius) for radius in (1, 2, 4)],
        "noise": [noisy(targets, sigma) for sigma in (0.02, 0.06, 0.15)],
    }[fault]
    assert worse([score(StRred(), outputs, targets)["strred"] for outputs in clips])
    assert worse([101 - score(Vmaf(), outputs, targets)["vmaf"] for outputs in clips])


def test_warping_error_penalises_noise_and_favours_blur(film):
    targets, motions = film
    reference = warping(targets, targets, motions)
    assert worse([reference] + [warping(noisy(targets, sigma), targets, motions) for sigma in (0.02, 0.06, 0.15)])
    assert warping(blurred(targets, 1), targets, motions) < 0.5 * reference
