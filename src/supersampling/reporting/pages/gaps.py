"""Values that a run lacks although others have them: such clips enter no mean and no comparison of it."""

from collections import defaultdict
from collections.abc import Sequence

import pandas as pd

from supersampling.runs.estimates import PLACE, ClipTables
from supersampling.runs.store import Run

Clip = tuple[str, int]
Clips = dict[str, set[Clip]]
"""Clips by metric."""


def gaps(runs: Sequence[Run], tables: ClipTables) -> dict[str, str]:
    """Return a sentence on what is missing of each incomplete run, by its id.

    A gap is a metric without a value (none, or NaN) on a clip where another run of the same data set has one. A metric
    that a run does not have at all is not a gap.
    """
    data_sets: defaultdict[str, dict[str, Clips]] = defaultdict(dict)
    for run in runs:
        if run.id in tables:
            data_sets[run.dataset][run.id] = _present(tables[run.id])
    sentences: dict[str, str] = {}
    for members in data_sets.values():
        union: defaultdict[str, set[Clip]] = defaultdict(set)
        for present in members.values():
            for name, clips in present.items():
                union[name] |= clips
        for run_id, present in members.items():
            missing = {name: union[name] - clips for name, clips in present.items() if union[name] - clips}
            if missing:
                sentences[run_id] = _sentence(missing)
    return sentences


def _present(table: pd.DataFrame) -> Clips:
    """Return the clips that have a value."""
    return {str(name): set(table.index[table[name].notna()]) for name in table if name not in PLACE}


def _sentence(missing: Clips) -> str:
    """Return one sentence in which metrics that lack the same clips stand together."""
    together: defaultdict[tuple[Clip, ...], list[str]] = defaultdict(list)
    for name, clips in sorted(missing.items()):
        together[tuple(sorted(clips))].append(name)
    sentences = []
    for places, names in together.items():
        scene, clip = places[0]
        place = f"clip {clip} of {scene}" if len(places) == 1 else f"{len(places)} clips, {scene} {clip} the first"
        sentences.append(f"{', '.join(names)} has no value on {place}: left out of every mean and difference with it")
    return "; ".join(sentences)
