"""Successive halving and the decision, against a brute-force oracle on synthetic qualities."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import hadamard

from supersampling.advice.halving import Criteria, decide, halve

MARGIN = 0.1
CLIPS = 8
SCENES = ["one"] * CLIPS


class World:
    """Candidates of known quality, scored on clips of different difficulty, with noise in each training."""

    def __init__(
        self, quality: NDArray[np.float64], cost: list[float], noise: float, seeds: int, rng: np.random.Generator
    ) -> None:
        self.quality, self.cost, self.noise, self.seeds, self.rng = quality, cost, noise, seeds, rng
        self.clips = rng.normal(30, 3, CLIPS)
        self.trained: list[tuple[int, int]] = []

    def score(self, candidate: int, rung: int) -> NDArray[np.float64]:
        self.trained.append((candidate, rung))
        noise = self.rng.normal(0, self.noise, (self.seeds, CLIPS))
        return self.clips + self.quality[rung, candidate] + noise

    def criteria(self, capacity: int = 1000) -> Criteria:
        return criteria(self.cost, capacity)


def criteria(cost: list[float], capacity: int = 9, **more: list) -> Criteria:
    return Criteria(cost=cost, margin=MARGIN, scenes=SCENES, capacity=lambda rung: capacity, **more)


def oracle(quality: NDArray[np.float64], cost: list[float]) -> int:
    """Return the cheapest of all candidates whose true loss is at most the margin."""
    answer, price = -1, np.inf
    for candidate, value in enumerate(quality):
        if quality.max() - value <= MARGIN and cost[candidate] < price:
            answer, price = candidate, cost[candidate]
    return answer


@pytest.mark.parametrize("seed", range(40))
def test_answer_is_that_of_the_oracle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 14))
    final = rng.uniform(-2, 0, count)
    final[np.abs(final.max() - final - MARGIN) < 0.04] -= 0.2  # no candidate is on the margin
    early = final - 3 + rng.normal(0, 0.02, count)  # shorter trainings are worse, in nearly the same order
    cost = list(rng.permutation(count) + 1.0)
    world = World(np.stack([early, final]), cost, 0.005, 2, rng)
    halving = halve(range(count), 2, world.criteria(), world.score)
    assert decide(halving.finalists, world.criteria()).selected == oracle(final, cost)


@pytest.mark.parametrize("seed", range(20))
def test_no_candidate_is_dropped_without_evidence_and_the_better_half_goes_on(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 12
    quality = rng.uniform(-0.6, 0, (1, count))
    world = World(np.repeat(quality, 2, axis=0), list(rng.uniform(1, 9, count)), 0.01, 1, rng)
    halving = halve(range(count), 2, world.criteria(), world.score)
    promoted = {c for c, rung in world.trained if rung == 1}
    means = {c: halving.values[0, c].mean() for c in range(count)}
    assert set(sorted(means, key=lambda c: -means[c])[: count // 2]) <= promoted
    truth = quality[0]
    for candidate in set(range(count)) - promoted:
        worse = truth.max() - truth[candidate] > MARGIN - 0.03
        beaten = any(
            world.cost[o] <= world.cost[candidate] and truth[o] > truth[candidate] - 0.03
            for o in range(count)
            if o != candidate
        )
        assert worse or beaten


def even(candidate: int, rung: int) -> NDArray[np.float64]:
    """Return the values of a candidate; all have the same mean and are good at different clips."""
    return 30 + 2.0 * hadamard(CLIPS)[candidate + 1 : candidate + 2]


def test_candidates_that_noise_hides_go_on() -> None:
    trained: list[tuple[int, int]] = []

    def score(candidate: int, rung: int) -> NDArray[np.float64]:
        trained.append((candidate, rung))
        return even(candidate, rung)

    halving = halve(range(6), 2, criteria([6, 5, 4, 3, 2, 1]), score)
    assert {c for c, rung in trained if rung == 1} == set(range(6))
    assert {s.verdict for s in halving.results if s.rung == 0} == {"better half", "not resolved"}


def test_clearly_worse_candidate_is_trained_once() -> None:
    rng = np.random.default_rng(0)
    world = World(np.array([[0.0, -0.05, -5.0, -6.0]] * 3), [4.0, 3.0, 2.0, 1.0], 0.001, 1, rng)
    halve(range(4), 3, world.criteria(), world.score)
    assert sorted(world.trained) == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (3, 0)]


def test_verdict_says_that_steps_run_out() -> None:
    halving = halve(range(6), 2, criteria([1] * 6, capacity=2), even)
    assert len(halving.finalists) == 2
    assert sum("no steps are left" in s.verdict for s in halving.results) == 4


def test_without_steps_for_a_second_round_the_first_decides() -> None:
    rng = np.random.default_rng(0)
    world = World(np.array([[0.0, -1.0]] * 2), [2.0, 1.0], 0.01, 1, rng)
    halving = halve(range(2), 2, world.criteria(capacity=0), world.score)
    assert halving.last_rung == 0
    assert sorted(halving.finalists) == [0, 1]


def test_failed_candidate_is_left_out() -> None:
    def score(candidate: int, rung: int) -> NDArray[np.float64] | None:
        return None if candidate == 1 else np.full((1, CLIPS), 30.0 - candidate)

    halving = halve(range(3), 2, criteria([1, 2, 3]), score)
    assert {c for _, c in halving.values} == {0, 2}
    assert halve(range(3), 2, criteria([1, 2, 3]), lambda c, r: None).values == {}


def test_mean_without_the_interval_does_not_decide() -> None:
    """The cheap candidate loses 0.05 dB in the mean, within the margin, but its interval exceeds the margin."""
    clips = np.linspace(20, 40, CLIPS)
    loss = 0.05 + np.array([0.4, -0.4] * (CLIPS // 2))
    values = {0: clips[None], 1: (clips - loss)[None]}
    decision = decide(values, criteria([2.0, 1.0]))
    assert decision.losses[1].mean == pytest.approx(0.05)
    assert decision.selected == decision.best == 0
    assert decision.unresolved == [1]


def test_cheaper_candidate_within_the_margin_is_selected() -> None:
    clips = np.linspace(20, 40, CLIPS)
    values = {0: clips[None], 1: (clips - 0.05)[None], 2: (clips - 0.5)[None]}
    decision = decide(values, criteria([3.0, 2.0, 1.0]))
    assert (decision.best, decision.selected, decision.unresolved) == (0, 1, [])


def test_single_clip_proves_nothing() -> None:
    values = {0: np.array([[30.0]]), 1: np.array([[29.99]])}
    decision = decide(values, replace(criteria([2.0, 1.0]), scenes=["one"]))
    assert (decision.selected, decision.unresolved) == (0, [1])


def test_inferior_answer_is_as_rare_as_the_interval_says() -> None:
    """The cheap candidate is worse by just over the margin; the answer may be wrong in one case of forty.

    Slightly more are tolerated.
    """
    wrong = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        world = World(np.array([[0.0, -MARGIN - 1e-6]]), [2.0, 1.0], 0.05, 1, rng)
        values = {c: world.score(c, 0) for c in range(2)}
        wrong += decide(values, world.criteria()).selected == 1 and values[0].mean() > values[1].mean()
    assert wrong <= 400 * 0.05


def test_plainest_of_equal_times_is_selected() -> None:
    """Times whose quartiles overlap are equal; the second is plainer, the third costs more by more than noise."""
    rng = np.random.default_rng(1)
    clips = rng.normal(30, 1, CLIPS)
    values = {c: (clips + 0.001 * c)[None] for c in range(3)}
    parts = [2, 1, 0]
    overlapping = [(9.0, 11.0), (9.5, 12.0), (13.0, 14.0)]
    assert decide(values, criteria([10.0, 10.5, 13.5], spread=overlapping, parts=parts)).selected == 1
    separate = [(9.0, 11.0), (11.1, 12.0), (13.0, 14.0)]
    assert decide(values, criteria([10.0, 11.5, 13.5], spread=separate, parts=parts)).selected == 0
