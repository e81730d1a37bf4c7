"""Values that a run lacks where others have them: such clips enter no mean and no comparison of it."""

from collections import defaultdict
from collections.abc import Sequence

import pandas as pd

from supersampling.runs.estimates import PLACE, ClipTables
from supersampling.runs.store import Run

Clip = tuple[str, int]
Present = dict[str, set[Clip]]
"""The clips with a value, by metric."""


def gaps(runs: Sequence[Run], tables: ClipTables) -> dict[str, str]:
    """What is missing of each run, by its id: metrics without a value (none, or NaN) on clips where another run of the same data
    set has one. A metric that a run does not have at all is none of its gaps."""
    data_sets: defaultdict[str, dict[str, Present]] = defaultdict(dict)
    for run in runs:
        if run.id in tables:
            data_sets[run.dataset][run.id] = _present(tables[run.id])
    found: dict[str, str] = {}
    for of_set in data_sets.values():
        anyone: defaultdict[str, set[Clip]] = defaultdict(set)
        for present in of_set.values():
            for name, clips in present.items():
                anyone[name] |= clips
        for run_id, present in of_set.items():
            lacking = {name: anyone[name] - clips for name, clips in present.items() if anyone[name] - clips}
            if lacking:
                found[run_id] = _sentence(lacking)
    return found


def _present(table: pd.DataFrame) -> Present:
    return {str(name): set(table.index[table[name].notna()]) for name in table if name not in PLACE}


def _sentence(lacking: Present) -> str:
    """Metrics that lack the same clips are told together."""
    together: defaultdict[tuple[Clip, ...], list[str]] = defaultdict(list)
    for name, missing in sorted(lacking.items()):
        together[tuple(sorted(missing))].append(name)
    said = []
    for clips, names in together.items():
        scene, clip = clips[0]
        where = f"clip {clip} of {scene}" if len(clips) == 1 else f"{len(clips)} clips, {scene} {clip} the first"
        said.append(f"{', '.join(names)} has no value on {where}: left out of every mean and difference with it")
    return "; ".join(said)
