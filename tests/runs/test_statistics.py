"""Intervals against the normal theory, and against data whose difference is known."""

import numpy as np
import pytest
from scipy import stats

from supersampling.runs.statistics import bootstrap_mean, paired_difference

NINE = np.repeat(np.arange(9), 4)


def test_the_half_width_of_many_normal_clips_is_the_textbook_one():
    values = np.random.default_rng(1).normal(30, 2, size=400)
    estimate = bootstrap_mean(values)
    assert estimate.mean == pytest.approx(values.mean())
    assert estimate.half_width == pytest.approx(stats.t.ppf(0.975, 399) * values.std(ddof=1) / 20)


@pytest.mark.parametrize("scenes", [3, 5, 9])
def test_of_few_scenes_it_is_student_s_of_their_means(scenes):
    values = np.random.default_rng(scenes).normal(0, 1, (scenes, 4)) + np.linspace(-1, 1, scenes)[:, None]
    textbook = stats.ttest_1samp(values.mean(axis=1), 0).confidence_interval()
    estimate = bootstrap_mean(values.ravel(), np.repeat(np.arange(scenes), 4))
    assert estimate.half_width == pytest.approx((textbook.high - textbook.low) / 2)
    assert estimate.scenes == scenes


def test_many_seeds_without_any_spread_of_scenes_give_their_textbook_half_width():
    seeds = np.random.default_rng(4).normal(0, 1, 60)
    values = np.repeat(seeds[:, None], 36, axis=1)
    estimate = bootstrap_mean(values, NINE)
    assert estimate.half_width == pytest.approx(stats.t.ppf(0.975, 59) * seeds.std(ddof=1) / np.sqrt(60))


def test_two_seeds_that_scatter_leave_one_degree_of_freedom():
    values = np.repeat([[1.0], [1.2]], 36, axis=1)
    estimate = bootstrap_mean(values, NINE)
    assert estimate.half_width == pytest.approx(0.1 * stats.t.ppf(0.975, 1))
    assert not estimate.resolved


def test_seeds_of_both_methods_widen_the_interval():
    rng = np.random.default_rng(5)
    clips = rng.normal(0.5, 0.3, 36)
    spread = np.array([[-0.3], [0.0], [0.3]])
    single = paired_difference(clips, np.zeros(36), NINE)
    first = paired_difference(clips + spread, np.zeros(36), NINE)
    both = paired_difference(clips + spread, 0 * clips + spread, NINE)
    assert single.half_width < 0.7 * first.half_width
    assert both.mean == pytest.approx(single.mean)
    # The same three numbers as seeds of both methods do not cancel.
    assert both.half_width > single.half_width + 0.1


def test_scenes_that_differ_widen_the_interval_of_their_clips():
    rng = np.random.default_rng(6)
    values = rng.normal(0, 1, 9)[NINE] + rng.normal(0, 0.1, 36)
    assert bootstrap_mean(values, NINE).half_width > 1.7 * bootstrap_mean(values).half_width


def test_a_skewed_spread_makes_a_skewed_interval():
    values = np.random.default_rng(7).gamma(0.5, 1, 20)
    estimate = bootstrap_mean(values)
    assert estimate.high - estimate.mean > 1.1 * (estimate.mean - estimate.low)
    mirrored = bootstrap_mean(-values)
    assert (mirrored.low, mirrored.high) == pytest.approx((-estimate.high, -estimate.low), rel=0.02)


def test_every_clip_weighs_the_same_and_neither_order_nor_unit_matters():
    rng = np.random.default_rng(8)
    scenes = np.array([0] * 7 + [1] * 2 + [2] * 3)
    values = rng.normal(scenes, 0.3, (3, 12))
    estimate = bootstrap_mean(values, scenes)
    assert estimate.mean == pytest.approx(values.mean())
    order = rng.permutation(12)
    shuffled = bootstrap_mean(1000 * values[:, order], scenes[order])
    assert (shuffled.low, shuffled.high) == pytest.approx((1000 * estimate.low, 1000 * estimate.high))


def test_pairing_removes_the_spread_between_clips():
    rng = np.random.default_rng(2)
    clips = rng.normal(30, 5, size=36)
    estimate = paired_difference(clips + 0.3 + rng.normal(0, 0.1, size=36), clips, NINE)
    assert estimate.low < 0.3 < estimate.high
    assert estimate.half_width < 0.1
    assert estimate.resolved
    assert bootstrap_mean(clips, NINE).half_width > 1


def test_no_difference_is_unresolved():
    same = paired_difference(np.array([1.0, -1.0, 2.0, -2.0]), np.zeros(4))
    assert not same.resolved
    exactly = paired_difference(np.arange(36.0), np.arange(36.0), NINE)
    assert (exactly.mean, exactly.half_width, exactly.resolved) == (0.0, 0.0, False)


def test_the_same_difference_on_every_clip_is_certain():
    estimate = paired_difference(np.full(36, 30.1), np.full(36, 30.0), NINE)
    assert estimate.half_width == 0
    assert estimate.resolved


@pytest.mark.parametrize("values", [np.array([31.0]), np.array([31.0, np.inf])])
def test_one_clip_and_infinite_values_have_no_interval(values):
    for estimate in (bootstrap_mean(values), paired_difference(values, values)):
        assert np.isnan(estimate.half_width)
        assert not estimate.resolved


def test_mismatched_arguments_raise():
    with pytest.raises(ValueError, match=r"\(3,\) and \(2,\)"):
        paired_difference(np.zeros(3), np.zeros(2))
    with pytest.raises(ValueError, match="each of the 3 clips"):
        bootstrap_mean(np.zeros(3), np.zeros(2))
    with pytest.raises(ValueError, match="a seed and a clip"):
        bootstrap_mean(np.zeros(0))
