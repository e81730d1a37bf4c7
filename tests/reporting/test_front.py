"""The front against all pairs, and the join of times with qualities."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trade_cases import NO, candidate, clip_scores, run, timing

from supersampling.reporting.methods import Method
from supersampling.reporting.trade.front import Candidate, Place, front, gap, list_candidates, places, plus
from supersampling.runs.statistics import Estimate, paired_difference

# Few values, so that ties are many.
NUMBERS = st.sampled_from([1.0, 2.0, 3.0, 4.0, 5.0, NO])


def beats(a: Candidate, b: Candidate, sign: float) -> bool:
    better, faster = sign * (a.quality.mean - b.quality.mean), b.ms - a.ms
    return better >= 0 and faster >= 0 and (better > 0 or faster > 0)


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=12), st.booleans())
@settings(max_examples=300, deadline=None)
def test_front_is_every_unbeaten_candidate(points, higher):
    candidates = [candidate(str(k), quality, ms) for k, (quality, ms) in enumerate(points)]
    sign = 1.0 if higher else -1.0
    usable = [c for c in candidates if not math.isnan(c.ms) and not math.isnan(c.quality.mean)]
    expected = {c.label for c in usable if not any(beats(rival, c, sign) for rival in usable)}
    best = front(candidates, higher)
    assert {c.label for c in best} == expected
    assert [c.ms for c in best] == sorted(c.ms for c in best)


def methods():
    """Two seeds of one method, one run of another, one that was never timed."""
    return [
        Method("a", [run("a", "0"), run("a", "1")], True),
        Method("b", [run("b")], True),
        Method("untimed", [run("untimed")], True),
    ]


KNOWN = {"a-0": "A", "a-1": "A", "b-0": "B", "untimed-0": "U"}
CLIPS = {
    "a-0": clip_scores(30.0, 1, 0.3),
    "a-1": clip_scores(30.2, 2, 0.3),
    "b-0": clip_scores(29.0, 3, 0.3),
    "untimed-0": clip_scores(40.0, 4),
}


def test_times_are_joined_with_the_quality_of_their_architecture():
    loss = Estimate(-0.5, -0.6, -0.4, 5, 5)
    timings = [
        timing(9.0, "old", architecture="A"),
        timing(3.0, "a", architecture="A"),
        timing(2.0, "a", architecture="A", backend="openvino"),
        timing(1.0, "a", architecture="A", precision="bfloat16"),
        timing(0.5, "a", architecture="A", backend="openvino", precision="int8"),
        timing(NO, "b", architecture="B", backend="compile", reason="No compiler."),
        timing(4.0, "b", architecture="B"),
        timing(1.0, "other", architecture="X"),
    ]
    candidates = list_candidates(methods(), timings, KNOWN, CLIPS, {("A", "openvino", "int8"): loss})
    assert [(c.label, c.how, c.ms) for c in candidates] == [
        ("a", "eager float32", 3.0),  # the newer of two
        ("a", "openvino float32", 2.0),
        ("a", "openvino int8", 0.5),  # bfloat16 has no measured cost
        ("b", "eager float32", 4.0),
    ]
    exact, faster, coarse, rival = candidates
    assert exact.quality.mean == pytest.approx(30.1)
    assert exact.quality == faster.quality
    assert coarse.quality.mean == pytest.approx(29.6)
    assert coarse.quality.half_width == pytest.approx(math.hypot(exact.quality.half_width, 0.1), rel=0.02)
    assert rival.quality.mean == pytest.approx(29.0)


def test_gaps_are_paired_over_clips():
    loss = Estimate(-0.5, -0.7, -0.4, 5, 5)
    timings = [
        timing(3.0, architecture="A"),
        timing(2.0, architecture="A", backend="openvino"),
        timing(0.5, architecture="A", backend="openvino", precision="int8"),
        timing(4.0, architecture="B"),
    ]
    exact, faster, coarse, rival = list_candidates(methods(), timings, KNOWN, CLIPS, {("A", "openvino", "int8"): loss})
    tables = [CLIPS[name]["psnr"].to_numpy() for name in ("a-0", "a-1")]
    expected = paired_difference(np.stack(tables), CLIPS["b-0"]["psnr"].to_numpy(), CLIPS["b-0"]["scene"])
    assert gap(exact, rival, CLIPS) == expected
    assert expected.resolved
    assert expected.half_width < exact.quality.half_width / 3
    assert gap(exact, faster, CLIPS) == Estimate(0.0, 0.0, 0.0, 10, 5)
    # Of the same weights the precision's cost is all: no difference between seeds or clips comes in.
    assert gap(coarse, exact, CLIPS) == Estimate(-0.5, pytest.approx(-0.7), pytest.approx(-0.4), 10, 5)
    assert gap(exact, coarse, CLIPS) == Estimate(0.5, pytest.approx(0.4), pytest.approx(0.7), 10, 5)
    assert gap(coarse, rival, CLIPS).mean == pytest.approx(expected.mean - 0.5)
    assert gap(exact, rival, {}) is None


def test_independent_errors_add_in_quadrature():
    rng = np.random.default_rng(0)
    a, b = rng.normal(3.0, 2.0, 400_000), rng.normal(1.0, 1.5, 400_000)

    def interval(values):
        return Estimate(float(values.mean()), *map(float, np.quantile(values, [0.025, 0.975])), 1)

    for sign in (1.0, -1.0):
        total, truth = plus(interval(a), interval(b), sign), interval(a + sign * b)
        assert (total.mean, total.low, total.high) == pytest.approx((truth.mean, truth.low, truth.high), abs=0.03)
    assert math.isnan(plus(interval(a), Estimate(1.0, NO, NO, 1)).low)


def test_times_of_different_places_stay_separate():
    timings = [timing(1.0), timing(2.0, backend="compile"), timing(3.0, threads=1), timing(4.0, width=1280, height=720)]
    first, *rest = places(timings)
    assert first == Place.of(timings[0])
    assert len(rest) == 2
    assert str(first) == "1920x1080 on cpu, 2 threads (a machine)"
    for a, b in itertools.combinations([first, *rest], 2):
        assert a != b
