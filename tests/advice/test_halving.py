"""Successive halving and the decision, against a brute-force oracle on made-up qualities."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import hadamard

from supersampling.advice.halving import Terms, decide, halve

MARGIN = 0.1
CLIPS = 8
SCENES = ["one"] * CLIPS


class World:
    """Candidates of known quality, seen through clips that are easier or harder for all, with noise of each training's own."""

    def __init__(
        self,
        quality: NDArray[np.float64],
        cost: list[float],
        noise: float,
        seeds: int,
        rng: np.random.Generator,
    ) -> None:
        self.quality, self.cost, self.noise, self.seeds, self.rng = quality, cost, noise, seeds, rng
        self.clips = rng.normal(30, 3, CLIPS)
        self.asked: list[tuple[int, int]] = []

    def score(self, candidate: int, rung: int) -> NDArray[np.float64]:
        self.asked.append((candidate, rung))
        noise = self.rng.normal(0, self.noise, (self.seeds, CLIPS))
        return self.clips + self.quality[rung, candidate] + noise

    def terms(self, room: int = 1000) -> Terms:
        return Terms(self.cost, MARGIN, SCENES, lambda rung: room)


def oracle(quality: NDArray[np.float64], cost: list[float]) -> int:
    """By the truth itself: of all candidates, the cheapest one that loses at most the margin."""
    answer, price = -1, np.inf
    for candidate, value in enumerate(quality):
        if quality.max() - value <= MARGIN and cost[candidate] < price:
            answer, price = candidate, cost[candidate]
    return answer


@pytest.mark.parametrize("seed", range(40))
def test_it_finds_what_a_full_walk_of_the_truth_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 14))
    final = rng.uniform(-2, 0, count)
    final[np.abs(final.max() - final - MARGIN) < 0.04] -= 0.2  # none lies on the margin
    early = final - 3 + rng.normal(0, 0.02, count)  # shorter trainings are worse, in nearly the same order
    cost = list(rng.permutation(count) + 1.0)
    world = World(np.stack([early, final]), cost, 0.005, 2, rng)
    search = halve(range(count), 2, world.terms(), world.score)
    last = {c: v for (rung, c), v in search.values.items() if rung == 1}
    assert decide(last, world.terms()).chosen == oracle(final, cost)


@pytest.mark.parametrize("seed", range(20))
def test_nobody_is_dropped_without_evidence_and_the_better_half_goes_on(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = 12
    quality = rng.uniform(-0.6, 0, (1, count))
    world = World(np.repeat(quality, 2, axis=0), list(rng.uniform(1, 9, count)), 0.01, 1, rng)
    search = halve(range(count), 2, world.terms(), world.score)
    on = {c for c, rung in world.asked if rung == 1}
    means = {c: search.values[0, c].mean() for c in range(count)}
    assert set(sorted(means, key=lambda c: -means[c])[: count // 2]) <= on
    truth = quality[0]
    for candidate in set(range(count)) - on:
        worse = truth.max() - truth[candidate] > MARGIN - 0.03
        beaten = any(
            world.cost[o] <= world.cost[candidate] and truth[o] > truth[candidate] - 0.03
            for o in range(count)
            if o != candidate
        )
        assert worse or beaten


def even(candidate: int, rung: int) -> NDArray[np.float64]:
    """Candidates of one mean that are good at different clips."""
    return 30 + 2.0 * hadamard(CLIPS)[candidate + 1 : candidate + 2]


def test_what_noise_hides_goes_on() -> None:
    asked: list[tuple[int, int]] = []

    def score(candidate: int, rung: int) -> NDArray[np.float64]:
        asked.append((candidate, rung))
        return even(candidate, rung)

    search = halve(range(6), 2, Terms([6, 5, 4, 3, 2, 1], MARGIN, SCENES, lambda rung: 9), score)
    assert {c for c, rung in asked if rung == 1} == set(range(6))
    assert {s.verdict for s in search.steps if s.rung == 0} == {"better half", "not resolved"}


def test_a_clearly_worse_one_is_trained_once() -> None:
    rng = np.random.default_rng(0)
    world = World(np.array([[0.0, -0.05, -5.0, -6.0]] * 3), [4.0, 3.0, 2.0, 1.0], 0.001, 1, rng)
    halve(range(4), 3, world.terms(), world.score)
    assert sorted(world.asked) == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (3, 0)]


def test_steps_that_run_out_are_said() -> None:
    search = halve(range(6), 2, Terms([1] * 6, MARGIN, SCENES, lambda rung: 2), even)
    assert len(search.finalists) == 2
    assert sum("no steps are left" in s.verdict for s in search.steps) == 4


def test_without_steps_for_a_second_round_the_first_decides() -> None:
    rng = np.random.default_rng(0)
    world = World(np.array([[0.0, -1.0]] * 2), [2.0, 1.0], 0.01, 1, rng)
    search = halve(range(2), 2, world.terms(room=0), world.score)
    assert search.last == 0
    assert sorted(search.finalists) == [0, 1]


def test_one_that_fails_is_left_out() -> None:
    search = halve(
        range(3),
        2,
        Terms([1, 2, 3], MARGIN, SCENES, lambda r: 9),
        lambda c, r: None if c == 1 else np.full((1, CLIPS), 30.0 - c),
    )
    assert {c for _, c in search.values} == {0, 2}
    assert halve(range(3), 2, Terms([1, 2, 3], MARGIN, SCENES, lambda r: 9), lambda c, r: None).values == {}


def test_the_mean_alone_does_not_decide() -> None:
    """The cheap one loses 0.05 dB in the mean, within the margin, but its interval reaches beyond."""
    clips = np.linspace(20, 40, CLIPS)
    loss = 0.05 + np.array([0.4, -0.4] * (CLIPS // 2))
    values = {0: clips[None], 1: (clips - loss)[None]}
    answer = decide(values, Terms([2.0, 1.0], MARGIN, SCENES, lambda r: 9))
    assert answer.losses[1].mean == pytest.approx(0.05)
    assert answer.chosen == answer.best == 0
    assert answer.open == [1]


def test_a_cheaper_one_within_the_margin_is_chosen() -> None:
    clips = np.linspace(20, 40, CLIPS)
    values = {0: clips[None], 1: (clips - 0.05)[None], 2: (clips - 0.5)[None]}
    answer = decide(values, Terms([3.0, 2.0, 1.0], MARGIN, SCENES, lambda r: 9))
    assert (answer.best, answer.chosen, answer.open) == (0, 1, [])


def test_one_clip_proves_nothing() -> None:
    values = {0: np.array([[30.0]]), 1: np.array([[29.99]])}
    answer = decide(values, Terms([2.0, 1.0], MARGIN, ["one"], lambda r: 9))
    assert (answer.chosen, answer.open) == (0, [1])


def test_an_inferior_answer_is_as_rare_as_the_interval_says() -> None:
    """The cheap one is worse by just over the margin: it may be called within it in one case of forty, and is in few more."""
    wrong = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        world = World(np.array([[0.0, -MARGIN - 1e-6]]), [2.0, 1.0], 0.05, 1, rng)
        values = {c: world.score(c, 0) for c in range(2)}
        wrong += decide(values, world.terms()).chosen == 1 and values[0].mean() > values[1].mean()
    assert wrong <= 400 * 0.05


def test_of_equal_times_the_plainest_is_the_answer() -> None:
    """Quartiles that overlap are no difference; the second is plainer, the third is dearer by more than noise."""
    rng = np.random.default_rng(1)
    clips = rng.normal(30, 1, CLIPS)
    values = {c: (clips + 0.001 * c)[None] for c in range(3)}
    spread = [(9.0, 11.0), (9.5, 12.0), (13.0, 14.0)]
    terms = Terms([10.0, 10.5, 13.5], MARGIN, SCENES, lambda r: 9, spread, [2, 1, 0])
    assert decide(values, terms).chosen == 1
    apart = Terms([10.0, 11.5, 13.5], MARGIN, SCENES, lambda r: 9, [(9.0, 11.0), (11.1, 12.0), (13.0, 14.0)], [2, 1, 0])
    assert decide(values, apart).chosen == 0
