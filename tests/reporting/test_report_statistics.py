"""Bootstrap intervals against the normal theory and against data whose difference is known."""

import numpy as np
import pytest

from supersampling.reporting.statistics import bootstrap_mean, paired_difference


def test_the_half_width_of_many_normal_clips_is_the_textbook_one() -> None:
    values = np.random.default_rng(1).normal(30, 2, size=400)
    estimate = bootstrap_mean(values)
    assert estimate.mean == pytest.approx(values.mean())
    assert estimate.half_width == pytest.approx(1.96 * values.std(ddof=1) / 20, rel=0.06)


def test_pairing_removes_the_spread_between_clips() -> None:
    rng = np.random.default_rng(2)
    clips = rng.normal(30, 5, size=16)
    base, better = clips, clips + 0.3 + rng.normal(0, 0.1, size=16)
    estimate = paired_difference(better, base)
    assert estimate.low < 0.3 < estimate.high
    assert estimate.half_width < 0.1
    assert estimate.resolved
    assert bootstrap_mean(base).half_width > 1


def test_the_interval_covers_the_truth_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(3)
    hits = [
        abs(e.mean - 0.5) < 5 and e.low <= 0.5 <= e.high
        for e in (bootstrap_mean(rng.normal(0.5, 1, 30)) for _ in range(200))
    ]
    assert 0.88 <= np.mean(hits) <= 0.99


def test_no_difference_is_unresolved() -> None:
    same = paired_difference(np.array([1.0, -1.0, 2.0, -2.0]), np.zeros(4))
    assert not same.resolved
    exactly = paired_difference(np.arange(5.0), np.arange(5.0))
    assert (exactly.mean, exactly.half_width, exactly.resolved) == (0.0, 0.0, False)


def test_one_clip_and_infinite_values_have_no_interval() -> None:
    for values in (np.array([31.0]), np.array([31.0, np.inf])):
        estimate = bootstrap_mean(values)
        assert np.isnan(estimate.half_width)
        assert not estimate.resolved


def test_unequal_clips_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(3,\) and \(2,\)"):
        paired_difference(np.zeros(3), np.zeros(2))
