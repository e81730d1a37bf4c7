"""Quantities of claims beyond the difference of clip means: least differences, factors, percent, frames, settling."""

import math
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest
from test_claims import PAIR, SCENES, claim, clips, judged, run

from supersampling.errors import UserError
from supersampling.reporting.pages.claims import _metric
from supersampling.reporting.papers.claims import side
from supersampling.reporting.papers.effects import of_frames
from supersampling.reporting.papers.quantity_checks import check_quantity
from supersampling.runs.statistics import Estimate


def frames(values: list[float], metric: str = "psnr") -> pd.DataFrame:
    """The same values by frame on two clips of each scene, frames out of order."""
    rows = [(s, clip, t, value) for s in SCENES for clip in (0, 1) for t, value in reversed(list(enumerate(values)))]
    return pd.DataFrame(rows, columns=["scene", "clip", "frame", metric])


@pytest.mark.parametrize(
    ("kind", "at_least", "low", "high", "expected"),
    [
        ("more", 1.0, 1.1, 1.2, "reproduced"),
        ("more", 1.0, 0.9, 1.2, "unresolved"),
        ("more", 1.0, 0.2, 0.9, "contradicted"),
        ("less", 1.0, -1.2, -1.1, "reproduced"),
        ("less", 1.0, -0.9, -0.2, "contradicted"),
        ("less", 1.0, 1.1, 1.2, "contradicted"),
        ("more", -0.1, -0.05, 0.2, "reproduced"),
        ("more", -0.1, -0.2, 0.2, "unresolved"),
        ("more", -0.1, -0.3, -0.2, "contradicted"),
    ],
)
def test_a_least_difference_moves_the_bound(kind: str, at_least: float, low: float, high: float, expected: str) -> None:
    assert side(claim(kind, at_least=at_least), Estimate((low + high) / 2, low, high, 8)) == expected


@pytest.mark.parametrize(("late", "verdict"), [(0.49, "reproduced"), (0.51, "contradicted")])
def test_a_factor_of_clip_scores(late: float, verdict: str) -> None:
    """The later is half at most, on every clip; the effect that is reported stays the plain difference."""
    tables = {"late": clips(late - 30, metric="static_std"), "early": clips(-29.0, metric="static_std")}
    for table in tables.values():  # one value on all clips: 30 + the gain
        table["static_std"] = table["static_std"].mean()
    result = judged(claim("less", metric="static_std", times=2), PAIR, tables)
    assert result.verdict == verdict
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(late - 1.0)
    assert set(result.scenes.values()) == {verdict == "reproduced"}


def test_a_claim_about_frames_sees_no_other_frames() -> None:
    tables = {"late": clips(1.0), "early": clips(0.0)}
    by_frame = {"late": frames([30, 30, 32, 34, 10]), "early": frames([40, 40, 31, 31, 40])}
    result = judged(claim(frames=[2, 3]), PAIR, tables, by_frame)
    assert result.verdict == "reproduced"
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(2.0)  # (32 + 34) / 2 - 31
    assert result.effect.clips == 12
    assert judged(claim(frames=[0, 1]), PAIR, tables, by_frame).verdict == "contradicted"
    beyond = judged(claim(frames=[9, 12]), PAIR, tables, by_frame)
    assert beyond.verdict == "not run"
    assert "not all logged psnr of frames 9 to 12" in beyond.reason


def test_frames_until_a_metric_settles() -> None:
    """The later half is 10, 12, 11, 11: median 11. The first value within 1.5 of it is the fourth."""
    slow = of_frames(frames([2, 5, 8, 9.6, 10, 12, 11, 11]), claim(settles=1.5))
    assert set(slow["psnr"]) == {4.0}
    fast, never = [11.0, 2, 2, 2, 10, 12, 11, 11], [0.0, 0.0, 0.0, 0.0, 0.0, 8.0, 0.0, 8.0]
    assert set(of_frames(frames(fast), claim(settles=1.5))["psnr"]) == {1.0}
    assert of_frames(frames(never), claim(settles=1.5))["psnr"].isna().all()
    by_frame = {"late": frames([2, 5, 8, 9.6, 10, 12, 11, 11]), "early": frames(fast)}
    assert judged(claim("more", settles=1.5), PAIR, {}, by_frame).verdict == "reproduced"
    assert judged(claim("less", settles=1.5), PAIR, {}, by_frame).verdict == "contradicted"


def test_a_difference_in_percent_of_the_other_side() -> None:
    runs = [
        run("late", metrics={"time/eager/ms": 150.0}, model__warp_at="target"),
        run("early", metrics={"time/eager/ms": 200.0}, model__warp_at="low"),
    ]
    saved = claim("less", metric="run:time/eager/ms", relative=True, at_least=20.0)
    result = judged(saved, runs, {})
    assert result.effect is not None
    assert result.effect.mean == pytest.approx(-25.0)
    assert result.verdict == "reproduced"
    assert _metric(saved) == "time/eager/ms: a − b < −20 %"
    assert judged(replace(saved, at_least=30.0), runs, {}).verdict == "contradicted"
    for margin, verdict in ((26.0, "reproduced"), (24.0, "contradicted")):
        within = claim("same", metric="run:time/eager/ms", relative=True, margin=margin)
        assert judged(within, runs, {}).verdict == verdict


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        ("more", {"frames": [3, 2]}, r"Invalid frames=\[3, 2\]"),
        ("more", {"frames": [3]}, r"Invalid frames=\[3\]"),
        ("more", {"frames": [1, 2], "metric": "run:model/gmac"}, "use one of them, of a metric that frames have"),
        ("more", {"settles": 0.0}, "Invalid settles=0"),
        ("more", {"relative": True}, "Invalid metric=psnr of relative: use a run: or benchmark: metric"),
        ("more", {"times": 2.0}, "Invalid times=2 of kind=more"),
        ("rises", {"at_least": 1.0}, "Invalid at_least=1 of kind=rises"),
        ("less", {"at_least": 1.0, "published": -0.9}, "use less than the published=-0.9"),
        ("less", {"at_least": 1.0, "published": 1.2}, "use less than the published=1.2"),
    ],
)
def test_impossible_quantities_are_reported(kind: str, fields: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        check_quantity(claim(kind, **fields), "small.yaml")


def test_a_median_of_nothing_has_no_value() -> None:
    assert math.isnan(of_frames(frames([math.nan, math.nan]), claim(settles=1.0))["psnr"].iloc[0])
