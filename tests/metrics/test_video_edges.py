"""Values of every video metric for degenerate clips: NaN, or the value in docs/metrics.md."""

import math

import pytest
import torch
from video_clips import score

from supersampling.metrics.video.colorvideovdp import ColorVideoVdp
from supersampling.metrics.video.static import StaticDeviation
from supersampling.metrics.video.strred import StRred
from supersampling.metrics.video.vmaf import Vmaf
from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError

pytest.importorskip("pycvvdp")
METRICS = [
    StaticDeviation(2),
    WarpingError(DualMotion()),
    WarpingError(Photometric()),
    StRred(),
    Vmaf(),
    ColorVideoVdp(),
]
COUNT = 4
TEXTURE = list(torch.rand(COUNT, 1, 3, 48, 64, generator=torch.Generator().manual_seed(0)))
BLACK, GREY, WHITE = ([torch.full((1, 3, 48, 64), level)] * COUNT for level in (0.0, 0.5, 1.0))
RATIOS = ("warping_error_ratio", "warping_error_photometric_ratio")


@pytest.fixture(scope="module")
def values():
    """Return the scores of all metrics for a camera at rest."""
    rest = [torch.zeros(1, 2, 12, 16)] * COUNT

    def of(outputs, targets):
        return {k: v for metric in METRICS for k, v in score(metric, outputs, targets, rest, rest).items()}

    return of


def nan_of(scores):
    return {name for name, value in scores.items() if math.isnan(value)}


def test_no_frame_has_no_value(values):
    scores = values([], [])
    assert nan_of(scores) == scores.keys()


def test_single_frame_has_values_of_metrics_without_pairs(values):
    scores = values(TEXTURE[:1], TEXTURE[1:2])
    assert scores.keys() - nan_of(scores) == {"static_std_fraction", "vmaf", "cvvdp"}


@pytest.mark.parametrize("frames", [TEXTURE, BLACK, GREY, WHITE], ids=["texture", "black", "grey", "white"])
def test_clip_against_itself(values, frames):
    scores = values(frames, frames)
    flat = frames is not TEXTURE
    assert nan_of(scores) == (set(RATIOS) if flat else set())  # the reference's error is 0
    for name in ("srred", "trred", "strred"):
        assert scores[name] == 0.0
    assert scores["cvvdp"] == 10.0
    assert scores["vmaf"] >= 97.42
    for name in ("static_std", "warping_error", "warping_error_photometric"):
        assert scores[name] == pytest.approx(scores[f"{name}_reference"], rel=1e-6)
        assert (scores[name] == 0.0) == flat


@pytest.mark.parametrize(("outputs", "targets"), [(GREY, TEXTURE), (TEXTURE, GREY), (BLACK, TEXTURE), (TEXTURE, BLACK)])
def test_flat_clip_against_texture_is_finite_and_bad(values, outputs, targets):
    scores = values(outputs, targets)
    assert nan_of(scores) == (set() if targets is TEXTURE else set(RATIOS))
    assert scores["strred"] > 1000
    assert scores["cvvdp"] < 7


def test_no_video_metric_sees_the_brightness_of_flat_frames(values):
    scores = values(BLACK, WHITE)
    assert scores["strred"] == 0.0
    assert scores["vmaf"] == pytest.approx(97.43, abs=0.01)
    assert scores["cvvdp"] == 10.0
