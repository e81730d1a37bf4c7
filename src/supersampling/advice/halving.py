"""Successive halving over training budgets, and the decision by non-inferiority.

Jamieson and Talwalkar 2016, "Non-stochastic best arm identification"; here no candidate is dropped without evidence.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from supersampling.runs.statistics import Estimate, paired_difference

Values = NDArray[np.float64]
Score = Callable[[int, int], "Values | None"]
"""``score(candidate, rung)``: one value per seed and clip, ``(seeds, clips)``, of the same clips; None if it failed."""


@dataclass(frozen=True, kw_only=True)
class RungResult:
    """The result of a candidate on a rung: its ``loss`` against the rung's best in dB, and the ``verdict``."""

    rung: int
    candidate: int
    mean: float
    loss: Estimate
    verdict: str
    goes_on: bool


@dataclass(frozen=True)
class Halving:
    """The results of all rungs, and the values of every candidate on every rung that it reached."""

    results: list[RungResult] = field(default_factory=list)
    values: dict[tuple[int, int], Values] = field(default_factory=dict)

    @property
    def last_rung(self) -> int:
        """The last rung that has values; -1 if none has."""
        return max((rung for rung, _ in self.values), default=-1)

    @property
    def finalists(self) -> dict[int, Values]:
        """The values of the candidates of the last rung."""
        return {candidate: values for (rung, candidate), values in self.values.items() if rung == self.last_rung}


@dataclass(frozen=True)
class Decision:
    """The candidate that is the answer.

    ``selected`` is the cheapest candidate whose loss against ``best`` is within the margin by the end of its interval;
    of several that cost the same, the one with the fewest parts. ``unresolved`` are the cheaper candidates whose
    interval includes the margin.
    """

    best: int
    selected: int
    losses: dict[int, Estimate]
    unresolved: list[int]


@dataclass(frozen=True, kw_only=True)
class Criteria:
    """The criteria of a search.

    Args:
        cost: of each candidate.
        margin: in dB.
        scenes: the scene of each clip.
        capacity: ``capacity(rung)`` is the number of candidates that can still be trained on a rung.
        spread: the quartiles of each cost; costs whose quartiles overlap are equal.
        parts: how many parts each candidate has beyond the plainest.
    """

    cost: Sequence[float]
    margin: float
    scenes: Sequence[str]
    capacity: Callable[[int], int]
    spread: Sequence[tuple[float, float]] = ()
    parts: Sequence[int] = ()

    def is_cheaper(self, first: int, second: int) -> bool:
        """Return whether the first candidate costs less than the second by more than the noise of both."""
        if not self.spread:
            return self.cost[first] < self.cost[second]
        return self.spread[first][1] < self.spread[second][0]


def estimate_loss(best: int, candidate: int, values: dict[int, Values], scenes: Sequence[str]) -> Estimate:
    """Return the loss of a candidate against ``best``, paired over clips; it is 0 for the best itself."""
    if best == candidate:
        clips = values[best].shape[1]
        return Estimate(0.0, 0.0, 0.0, clips, len(set(scenes)))
    return paired_difference(values[best], values[candidate], np.asarray(scenes))


def halve(candidates: Sequence[int], rungs: int, criteria: Criteria, score: Score) -> Halving:
    """Train all candidates on the first rung; promote the better half, and the others with no evidence against them.

    A candidate of the lower half is dropped if its interval says that it is worse than the rung's best by more than the
    margin, or that a candidate which costs no more is better. If more remain than can be afforded, those with the
    lowest means are dropped.
    """
    halving = Halving()
    promoted = list(candidates)
    for rung in range(rungs):
        values = {c: v for c in promoted if (v := score(c, rung)) is not None}
        if not values:
            break
        halving.values.update({(rung, c): v for c, v in values.items()})
        ranked = sorted(values, key=lambda c: -float(values[c].mean()))
        final = rung + 1 == rungs
        capacity = len(ranked) if final else criteria.capacity(rung + 1)
        promoted = []
        for place, candidate in enumerate(ranked):
            loss = estimate_loss(ranked[0], candidate, values, criteria.scenes)
            verdict, goes_on = _judge(place, ranked, values, loss, criteria)
            if goes_on and len(promoted) >= capacity:
                verdict, goes_on = f"{verdict}, but no steps are left for it", False
            if goes_on:
                promoted.append(candidate)
            halving.results.append(
                RungResult(
                    rung=rung,
                    candidate=candidate,
                    mean=float(values[candidate].mean()),
                    loss=loss,
                    verdict="last rung" if final else verdict,
                    goes_on=goes_on,
                )
            )
        if not promoted:
            break
    return halving


def _judge(
    place: int, ranked: list[int], values: dict[int, Values], loss: Estimate, criteria: Criteria
) -> tuple[str, bool]:
    if place < (len(ranked) + 1) // 2:
        return "better half", True
    if loss.low > criteria.margin:
        return "worse by more than the margin", False
    candidate = ranked[place]
    for better in ranked[:place]:
        lead = estimate_loss(better, candidate, values, criteria.scenes)
        if criteria.cost[better] <= criteria.cost[candidate] and lead.low > 0:
            return "one that costs no more is better", False
    return "not resolved", True


def decide(values: dict[int, Values], criteria: Criteria) -> Decision:
    """Select the cheapest candidate that is not inferior to the best by more than the margin.

    Args:
        values: of the candidates of the last rung.
    """
    best = max(values, key=lambda c: float(values[c].mean()))
    losses = {c: estimate_loss(best, c, values, criteria.scenes) for c in values}
    within_margin = [c for c, loss in losses.items() if loss.high <= criteria.margin]
    cheapest = min(within_margin, key=lambda c: criteria.cost[c])
    equal = [c for c in within_margin if not criteria.is_cheaper(cheapest, c)]
    parts = criteria.parts or [0] * (max(equal) + 1)
    selected = min(equal, key=lambda c: (parts[c], criteria.cost[c], losses[c].mean))
    unresolved = [
        c
        for c, loss in losses.items()
        if criteria.is_cheaper(c, selected) and not loss.high <= criteria.margin and not loss.low > criteria.margin
    ]
    return Decision(best, selected, losses, sorted(unresolved, key=lambda c: criteria.cost[c]))
