"""The contribution of each part of a model on a scene, in dB and ms, from pairs that differ in this part only."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from supersampling.advice.halving import Values
from supersampling.advice.space import ModelComposition, Space, Switch
from supersampling.runs.statistics import Estimate, paired_difference


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """The contribution of ``part`` against ``without``, two options of ``switch``.

    It is estimated from ``pairs`` of compositions that differ in nothing else. ``db`` is how much better the part is,
    ``ms`` how much slower.
    """

    switch: str
    part: str
    without: str
    rung: int
    pairs: int
    db: Estimate
    ms: float


def estimate_contributions(
    space: Space,
    compositions: Sequence[ModelComposition],
    values: Mapping[tuple[int, int], Values],
    costs: Sequence[float],
    scenes: Sequence[str],
) -> list[Contribution]:
    """Return the contribution of every option against the next plainer one, on every rung that has a pair.

    Pairs are resampled like seeds, so that the interval includes how much a contribution depends on the other parts.
    """
    rungs = sorted({rung for rung, _ in values})
    contributions = []
    for switch in space.switches:
        for part, without in pairwise(switch.options):
            pairs = _pairs(compositions, switch, part, without)
            for rung in rungs:
                measured = [(a, b) for a, b in pairs if (rung, a) in values and (rung, b) in values]
                if not measured:
                    continue
                lead = np.concatenate([_subtract(values[rung, a], values[rung, b]) for a, b in measured])
                contributions.append(
                    Contribution(
                        switch=switch.name,
                        part=part,
                        without=without,
                        rung=rung,
                        pairs=len(measured),
                        db=paired_difference(lead, np.zeros((1, lead.shape[1])), np.asarray(scenes)),
                        ms=float(np.mean([costs[a] - costs[b] for a, b in measured])),
                    )
                )
    return contributions


def _pairs(compositions: Sequence[ModelComposition], switch: Switch, part: str, without: str) -> list[tuple[int, int]]:
    number = {tuple(c.options.items()): k for k, c in enumerate(compositions)}
    pairs = []
    for k, composition in enumerate(compositions):
        plainer = number.get(tuple({**composition.options, switch.name: without}.items()))
        if composition.options[switch.name] == part and plainer is not None:
            pairs.append((k, plainer))
    return pairs


def _subtract(first: Values, second: Values) -> Values:
    """Return the difference of the seeds that both have."""
    count = min(len(first), len(second))
    return first[:count] - second[:count]


def select_latest(contributions: Sequence[Contribution]) -> list[Contribution]:
    """Return, for each pair of options, the contribution of the last rung that has it."""
    return list({(c.switch, c.part): c for c in sorted(contributions, key=lambda c: c.rung)}.values())
