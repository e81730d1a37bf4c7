"""Picks against tables that were decided by hand."""

import math

import pytest
from trade_cases import NO, candidate, clip_scores, run, timing

from supersampling.errors import UserError
from supersampling.reporting.methods import Method
from supersampling.reporting.trade.front import Candidate, list_candidates
from supersampling.reporting.trade.pick import Rendering, paired, sentences, upper, within_db, within_ms
from supersampling.runs.statistics import Estimate

ALONE = Rendering()


def gaps(half: float):
    """Differences of the means, every interval as wide."""

    def of(a: Candidate, b: Candidate) -> Estimate:
        mean = a.quality.mean - b.quality.mean
        return Estimate(mean, mean - half, mean + half, 10, 5)

    return of


TABLE = [
    candidate("slow", 31.0, 20.0),
    candidate("good", 30.0, 8.0),
    candidate("close", 29.95, 4.0),
    candidate("plain", 28.0, 1.0),
    candidate("wasteful", 27.0, 15.0),
    candidate("broken", 50.0, NO),
    candidate("unscored", NO, 0.1),
]


@pytest.mark.parametrize(
    ("ms", "half", "best", "tied"),
    [
        (100.0, 0.1, "slow", []),
        (100.0, 1.02, "slow", ["good"]),
        (100.0, 1.2, "slow", ["close", "good"]),  # fastest first
        (10.0, 0.01, "good", []),
        (10.0, 0.1, "good", ["close"]),
        (8.0, 0.01, "good", []),  # a time that is met exactly is within
        (7.9, 0.1, "close", []),
        (1.0, 9.9, "plain", []),
    ],
)
def test_the_best_within_a_time(ms, half, best, tied):
    answer = within_ms(TABLE, ms, ALONE, gaps(half))
    assert answer.selected.label == best
    assert [c.label for c in answer.tied] == tied


@pytest.mark.parametrize(
    ("db", "half", "selected"),
    [
        (0.0, 0.0, "slow"),
        (0.5, 0.1, "slow"),
        (1.0, 0.1, "slow"),  # the mean would do, the interval's end does not
        (1.12, 0.1, "good"),
        (1.16, 0.1, "close"),
        (1.06, 0.0, "close"),
        (3.2, 0.1, "plain"),
        (99.0, 0.1, "plain"),
    ],
)
def test_the_fastest_within_a_loss_is_decided_by_the_intervals_end(db, half, selected):
    assert within_db(TABLE, db, ALONE, gaps(half)).selected.label == selected


def test_budget_applies_to_the_upper_quartile():
    candidates = [candidate("steady", 28.0, 4.0, high=4.1), candidate("restless", 30.0, 4.0, high=6.0)]
    assert within_ms(candidates, 5.0, ALONE, gaps(0.1)).selected.label == "steady"
    assert upper(candidate("one frame", 1.0, 3.0, high=NO)) == 3.0


def test_ties_go_to_the_faster():
    candidates = [candidate("a", 30.0, 5.0), candidate("b", 30.0, 4.0), candidate("b twin", 30.0, 4.0)]
    answer = within_ms(candidates, 9.0, ALONE, gaps(0.1))
    assert answer.selected.label == "b"
    assert [c.label for c in answer.tied] == ["b twin", "a"]
    assert within_db(candidates, 0.0, ALONE, gaps(0.0)).selected.label == "b"


def test_fastest_backend_represents_a_method():
    candidates = [candidate("m", 30.0, ms, backend=name) for name, ms in (("eager", 9.0), ("openvino", 3.0))]
    candidates.append(candidate("m", 29.9, 2.0, backend="openvino", precision="int8"))
    answer = within_ms(candidates, 10.0, ALONE, gaps(0.2))
    assert answer.selected.how == "openvino float32"
    assert [c.how for c in answer.tied] == ["openvino int8"]


def test_without_an_interval_nothing_is_tied_or_near():
    """One clip."""

    def unknown(a, b):
        return Estimate(a.quality.mean - b.quality.mean, NO, NO, 1)

    answer = within_ms(TABLE, 10.0, ALONE, unknown)
    assert (answer.selected.label, answer.tied, answer.undecided) == ("good", (), 2)
    assert within_db(TABLE, 5.0, ALONE, unknown).selected.label == "slow"
    assert "no interval" in " ".join(sentences(answer, ms=10.0))


def test_real_statistics_of_one_seed_pair_scenes():
    """Scenes differ by decibels, methods by a tenth: pairing resolves it, and one seed suffices for its own weights."""
    names = {"a": (30.0, 1, 0.02), "b": (29.9, 2, 0.02), "c": (29.99, 3, 0.05)}
    clips = {f"{name}-0": clip_scores(*how) for name, how in names.items()}
    timings = [timing(ms, name) for name, ms in zip(names, (9.0, 5.0, 2.0))]
    candidates = list_candidates(
        [Method(name, [run(name)], True) for name in names], timings, {f"{n}-0": n for n in names}, clips, {}
    )
    answer = within_ms(candidates, 10.0, ALONE, paired(clips))
    assert answer.selected.label == "a"
    assert [c.label for c in answer.tied] == ["c"]
    assert within_db(candidates, 0.2, ALONE, paired(clips)).selected.label == "c"
    assert within_db(candidates, 0.001, ALONE, paired(clips)).selected.label == "a"
    printed = " ".join(sentences(answer, ms=10.0))
    assert "cannot tell it from c" in printed
    assert "The fastest of these is c" in printed


@pytest.mark.parametrize("ms", [0, 0.0, -1.0, NO, math.inf, "soon", True])
def test_invalid_time(ms):
    with pytest.raises(UserError, match=rf"Invalid ms={ms}: .* fastest here is plain .*1 ms"):
        within_ms(TABLE, ms, ALONE, gaps(0.1))


@pytest.mark.parametrize("db", [-0.1, NO, math.inf, "little"])
def test_invalid_loss(db):
    with pytest.raises(UserError, match=rf"Invalid db={db}: .*plain"):
        within_db(TABLE, db, ALONE, gaps(0.1))


def test_time_below_the_fastest():
    with pytest.raises(UserError, match=r"within ms=0.5: use more; the fastest is plain .*1 ms"):
        within_ms(TABLE, 0.5, ALONE, gaps(0.1))
    with pytest.raises(UserError, match=r"within ms=2: .* with its rendering 4 ms"):
        within_ms(TABLE, 2.0, Rendering(3.0), gaps(0.1))


def test_without_candidates():
    for candidates in ([], TABLE[-2:]):
        with pytest.raises(UserError, match="train on this data set"):
            within_ms(candidates, 5.0, ALONE, gaps(0.1))


def test_rendering_counts_and_the_answer_states_whether_upscaling_pays():
    rendering = Rendering.of(5.0, 12.0)
    answer = within_ms(TABLE, 10.0, rendering, gaps(0.01))
    assert answer.selected.label == "close"  # 5 + 8 of the better one are too many
    assert "Upscaling pays: 5 + 4 = 9 ms a frame, against 12 ms" in " ".join(sentences(answer, ms=10.0))
    slow = within_ms(TABLE, 30.0, rendering, gaps(0.01))
    assert "does not pay" in " ".join(sentences(slow, ms=30.0))
    assert "Rendering low and upscaling" in " ".join(
        sentences(within_ms(TABLE, 10.0, Rendering.of(5.0, None), gaps(0.1)), ms=10.0)
    )


@pytest.mark.parametrize(
    ("low", "high", "message"),
    [
        (0.0, None, "Invalid low_ms=0.0"),
        (-1.0, 5.0, "Invalid low_ms=-1.0"),
        (NO, None, "Invalid low_ms=nan"),
        (3.0, 0.0, "Invalid high_ms=0.0"),
        (None, 5.0, "high_ms=5.0 needs low_ms"),
    ],
)
def test_invalid_rendering(low, high, message):
    with pytest.raises(UserError, match=message):
        Rendering.of(low, high)
