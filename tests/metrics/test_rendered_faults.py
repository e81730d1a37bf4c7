"""Faults in a rendered clip: each is detected by its metrics, and some metrics are blind to some faults.

The faults, and what blind means, are those of scripts/timing/blind.py, which makes the table in docs/metrics.md.
"""

import runpy
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
import torch
from video_clips import blurred, flickering, noisy, score

from supersampling.metrics.flip import FLIP
from supersampling.metrics.image import psnr, ssim_gauss11
from supersampling.metrics.radiance import PSNRMu
from supersampling.metrics.regions import Regions
from supersampling.metrics.still import PSNR, SSIM
from supersampling.metrics.temporal import Temporal
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, WarpingError

table = SimpleNamespace(**runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "timing" / "blind.py")))

COUNT = 6
CATCHES = {
    "flicker": {"temporal", "warping_error", "static_std"},
    "ghost": {"psnr_disoccluded", "psnr_moving"},
    "shift": {"psnr", "ssim", "flip", "vmaf"},
    "tone map": {"psnr", "flip", "strred"},
    "channels": {"psnr", "ssim", "flip", "psnr_hdr_mu"},
    "tint": {"psnr", "flip"},
    "blur": {"ssim", "flip", "vmaf"},
    "noise": {"ssim", "temporal", "warping_error", "static_std"},
}
BLIND = {
    "flicker": {"psnr", "vmaf"},
    "ghost": {"static_std"},
    "tone map": {"psnr_hdr_mu", "static_std"},
    "channels": {"static_std", "warping_error"},
    "tint": {"vmaf", "strred", "static_std", "warping_error"},
    "blur": {"static_std", "warping_error"},
}


@pytest.fixture(scope="module")
def values(film):
    """By fault, then by metric."""
    buffers = (film.targets, film.motions, film.duals, [target for _, target in film.radiance])
    clip = table.Clip(*(torch.cat(images[:COUNT]) for images in buffers))
    frames = [PSNR(), SSIM(), FLIP(), PSNRMu(1.0), Temporal(), Regions()]
    clips = [StaticDeviation(3), WarpingError(DualMotion()), StRred(), Vmaf()]
    return {name: table.scores(clip, fault(clip), frames, clips) for name, fault in table.FAULTS.items()}


def blind(values, name):
    return table.blind_to(name, {fault: row[name] for fault, row in values.items()})


@pytest.mark.parametrize("fault", CATCHES)
def test_each_fault_is_detected_by_its_metrics(values, fault):
    for name in CATCHES[fault]:
        assert fault not in blind(values, name), name


@pytest.mark.parametrize("fault", BLIND)
def test_blind_metrics(values, fault):
    for name in BLIND[fault]:
        assert fault in blind(values, name), name


def test_ghost_trail_is_worst_just_after_disocclusion(values):
    ghost = values["ghost"]
    assert ghost["psnr_disoccluded"] < ghost["psnr_elsewhere"] - 6


def frame_mean(metric, outputs, targets):
    return torch.cat([metric(o, t) for o, t in zip(outputs, targets)]).mean().item()


def test_more_of_fault_is_worse(film):
    targets, motions, duals = film.targets, film.motions, film.duals

    def rising(measure, clips):
        losses = [measure(outputs) for outputs in clips]
        assert all(more > 1.02 * less for less, more in pairwise(losses)), losses

    def warping(outputs):
        return score(WarpingError(DualMotion()), outputs, targets, motions, duals)["warping_error"]

    blurs = [blurred(targets, radius) for radius in (1, 2, 4)]
    noises = [noisy(targets, sigma) for sigma in (0.02, 0.06, 0.15)]
    for clips in (blurs, noises):
        rising(lambda outputs: -frame_mean(psnr, outputs, targets) + 100, clips)
        rising(lambda outputs: 1 - frame_mean(ssim_gauss11, outputs, targets), clips)
        rising(lambda outputs: 101 - score(Vmaf(), outputs, targets)["vmaf"], clips)
        rising(lambda outputs: score(StRred(), outputs, targets)["strred"], clips)
    rising(warping, [targets, *noises])
    rising(warping, [flickering(targets, height) for height in (0.0, 0.02, 0.05, 0.1)])
    assert warping(blurs[2]) < warping(targets)  # blur pleases it
