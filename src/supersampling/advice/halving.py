"""Successive halving over training budgets (Jamieson and Talwalkar 2016, "Non-stochastic best arm identification"), in which
nobody is dropped without evidence, and the answer by non-inferiority."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from supersampling.runs.statistics import Estimate, paired_difference

Values = NDArray[np.float64]
Score = Callable[[int, int], "Values | None"]
"""``score(candidate, rung)``: a value for each seed and clip, ``(seeds, clips)``, of the same clips; None of one that failed."""


@dataclass(frozen=True)
class Step:
    """What became of a candidate on a rung: its ``loss`` against the rung's best in dB, and the ``verdict``."""

    rung: int
    candidate: int
    mean: float
    loss: Estimate
    verdict: str
    goes_on: bool


@dataclass(frozen=True)
class Search:
    """Every step, and the values of every candidate on every rung that it reached."""

    steps: list[Step] = field(default_factory=list)
    values: dict[tuple[int, int], Values] = field(default_factory=dict)

    @property
    def last(self) -> int:
        return max((rung for rung, _ in self.values), default=-1)

    @property
    def finalists(self) -> list[int]:
        return [candidate for rung, candidate in self.values if rung == self.last]


@dataclass(frozen=True)
class Answer:
    """``chosen`` is the cheapest candidate whose loss against ``best`` lies within the margin by its interval's end; of several
    that cost the same, the one of fewest parts. ``open`` are the cheaper ones of which the interval says neither."""

    best: int
    chosen: int
    losses: dict[int, Estimate]
    open: list[int]


@dataclass(frozen=True)
class Terms:
    """What a search is made by: each candidate's ``cost``, the ``margin`` in dB, the clips' scenes, and ``room(rung)``: how many
    trainings of a rung can be afforded. Costs are the same where their ``spread`` (quartiles) overlaps; ``parts`` is how much a
    candidate has beyond the plainest."""

    cost: Sequence[float]
    margin: float
    scenes: Sequence[str]
    room: Callable[[int], int]
    spread: Sequence[tuple[float, float]] = ()
    parts: Sequence[int] = ()

    def cheaper(self, one: int, other: int) -> bool:
        """Whether ``one`` costs less by more than the noise of both."""
        if not self.spread:
            return self.cost[one] < self.cost[other]
        return self.spread[one][1] < self.spread[other][0]


def loss_of(best: int, other: int, values: dict[int, Values], scenes: Sequence[str]) -> Estimate:
    """How much ``other`` loses against ``best``, paired over clips; a candidate loses nothing against itself."""
    if best == other:
        clips = values[best].shape[1]
        return Estimate(0.0, 0.0, 0.0, clips, len(set(scenes)))
    return paired_difference(values[best], values[other], np.asarray(scenes))


def halve(candidates: Sequence[int], rungs: int, terms: Terms, score: Score) -> Search:
    """Train all on the first rung; on the next go the better half, and of the others those that nothing speaks against.

    A candidate of the lower half is dropped if its interval says that it is worse than the rung's best by more than the margin,
    or that one which costs no more is better. Where that leaves more than can be afforded, the lowest means wait.
    """
    search = Search()
    alive = list(candidates)
    for rung in range(rungs):
        values = {c: v for c in alive if (v := score(c, rung)) is not None}
        if not values:
            break
        search.values.update({(rung, c): v for c, v in values.items()})
        ranked = sorted(values, key=lambda c: -float(values[c].mean()))
        left = terms.room(rung + 1) if rung + 1 < rungs else len(ranked)
        alive = []
        for place, candidate in enumerate(ranked):
            loss = loss_of(ranked[0], candidate, values, terms.scenes)
            verdict, goes_on = _verdict(place, candidate, ranked, values, loss, terms)
            if goes_on and len(alive) >= left:
                verdict, goes_on = f"{verdict}, but no steps are left for it", False
            if goes_on:
                alive.append(candidate)
            final = rung + 1 == rungs
            search.steps.append(
                Step(
                    rung,
                    candidate,
                    float(values[candidate].mean()),
                    loss,
                    "last rung" if final else verdict,
                    goes_on,
                )
            )
        if not alive:
            break
    return search


def _verdict(
    place: int, candidate: int, ranked: list[int], values: dict[int, Values], loss: Estimate, terms: Terms
) -> tuple[str, bool]:
    if place < (len(ranked) + 1) // 2:
        return "better half", True
    if loss.low > terms.margin:
        return "worse by more than the margin", False
    for other in ranked[:place]:
        ahead = loss_of(other, candidate, values, terms.scenes)
        if terms.cost[other] <= terms.cost[candidate] and ahead.low > 0:
            return "one that costs no more is better", False
    return "not resolved", True


def decide(values: dict[int, Values], terms: Terms) -> Answer:
    """The cheapest candidate that is not inferior to the best by more than the margin; ``values`` are of the last rung."""
    best = max(values, key=lambda c: float(values[c].mean()))
    losses = {c: loss_of(best, c, values, terms.scenes) for c in values}
    fit = [c for c, loss in losses.items() if loss.high <= terms.margin]
    cheapest = min(fit, key=lambda c: terms.cost[c])
    alike = [c for c in fit if not terms.cheaper(cheapest, c)]
    chosen = min(alike, key=lambda c: (terms.parts[c] if terms.parts else 0, terms.cost[c], losses[c].mean))
    open_ = [
        c
        for c, loss in losses.items()
        if terms.cheaper(c, chosen) and not loss.high <= terms.margin and not loss.low > terms.margin
    ]
    return Answer(best, chosen, losses, sorted(open_, key=lambda c: terms.cost[c]))
