"""What each part of a model contributed on a scene: decibels and milliseconds, of the pairs that differ in it alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from supersampling.advice.halving import Values
from supersampling.advice.space import Composition, Space
from supersampling.runs.statistics import Estimate, paired_difference


@dataclass(frozen=True)
class Contribution:
    """Of ``part`` against ``without``, two options of ``switch``, over ``pairs`` of compositions that differ in nothing else.

    ``db`` is how much better the part is, ``ms`` how much slower.
    """

    switch: str
    part: str
    without: str
    rung: int
    pairs: int
    db: Estimate
    ms: float


def contributions(
    space: Space,
    compositions: Sequence[Composition],
    values: Mapping[tuple[int, int], Values],
    costs: Sequence[float],
    scenes: Sequence[str],
) -> list[Contribution]:
    """Of every option against the next plainer one, on every rung that has a pair.

    Pairs and seeds are resampled like seeds: how much a part brings beside different other parts is in its interval.
    """
    number = {tuple(c.options.items()): k for k, c in enumerate(compositions)}
    rungs = sorted({rung for rung, _ in values})
    found = []
    for switch in space.switches:
        names = list(switch.options)
        for part, without in pairwise(names):
            for rung in rungs:
                pairs = [
                    (k, other)
                    for k, c in enumerate(compositions)
                    if c.options[switch.name] == part
                    and (other := number.get(tuple({**c.options, switch.name: without}.items()))) is not None
                    and (rung, k) in values
                    and (rung, other) in values
                ]
                if pairs:
                    ahead = np.concatenate([_matched(values[rung, a], values[rung, b]) for a, b in pairs])
                    db = paired_difference(ahead, np.zeros((1, ahead.shape[1])), np.asarray(scenes))
                    ms = float(np.mean([costs[a] - costs[b] for a, b in pairs]))
                    found.append(Contribution(switch.name, part, without, rung, len(pairs), db, ms))
    return found


def _matched(ours: Values, theirs: Values) -> Values:
    count = min(len(ours), len(theirs))
    return ours[:count] - theirs[:count]


def latest(found: Sequence[Contribution]) -> list[Contribution]:
    """Of each pair of options those of the last rung that has them."""
    return list({(c.switch, c.part): c for c in sorted(found, key=lambda c: c.rung)}.values())
