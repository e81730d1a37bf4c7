"""The comparison of two methods over the same clips: paired differences, their intervals, and verdicts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from supersampling.errors import UserError
from supersampling.metrics.directions import better
from supersampling.reporting.format import UNRESOLVED, decimals, fixed, plus_minus, span
from supersampling.reporting.seeds import SHORT, Group
from supersampling.reporting.selection import settings
from supersampling.runs.estimates import PLACE, ClipTables, difference, estimate
from supersampling.runs.statistics import LEVEL, Estimate

NO_INTERVAL, EQUAL = "no interval", "equal on every clip"


@dataclass(frozen=True, kw_only=True)
class Compared:
    """One metric of two methods: the mean of each, ``a - b`` paired, and the verdict."""

    metric: str
    a: Estimate
    b: Estimate
    difference: Estimate
    verdict: str


def compare(a: Group, b: Group, tables: ClipTables, metrics: Sequence[str] | None = None) -> list[Compared]:
    """Return the comparison of every metric that all runs of both groups logged, or of the requested ones.

    Raises:
        UserError: a run has no clip table, there is no common metric or clip, or a requested metric was not logged.
    """
    runs = [*a.runs, *b.runs]
    without = [run.id for run in runs if run.id not in tables]
    if without:
        raise UserError(f"Run {without[0]} has no table of its clips: score it again with evaluate.py.")
    common = [name for name in _metrics(tables[runs[0].id]) if all(name in tables[run.id] for run in runs)]
    if not common:
        raise UserError(f"No metric is common to {a.label} and {b.label}: score both with the same metrics=....")
    unknown = [name for name in metrics or () if name not in common]
    if unknown:
        raise UserError(f"Not every run logged metric={','.join(unknown)}: choose from {', '.join(common)}.")
    sides = _sides(a, b)
    compared = []
    for name in metrics or common:
        first, second = estimate(a.runs, name, tables), estimate(b.runs, name, tables)
        delta = difference(a.runs, b.runs, name, tables)
        if first is None or second is None or delta is None:
            raise UserError(
                f"No clip with a value of {name} is common to {a.label} and {b.label}: score both on the same clips."
            )
        compared.append(
            Compared(metric=name, a=first, b=second, difference=delta, verdict=verdict(name, delta, *sides))
        )
    return compared


def _sides(a: Group, b: Group) -> tuple[str, str]:
    """Return the shortest names that distinguish the two in a verdict."""
    for first, second in ((a.runs[0].model, b.runs[0].model), (a.label, b.label)):
        if first != second:
            return first, second
    return "a", "b"


def verdict(metric: str, delta: Estimate, a: str, b: str) -> str:
    """Return which is better, if the interval of ``a - b`` says so and the metric's direction is known."""
    if math.isnan(delta.low):
        return NO_INTERVAL
    if delta.low == delta.high == 0:
        return EQUAL
    if not delta.resolved:
        return UNRESOLVED
    way = better(metric)
    if way in (None, "neither"):
        return "a is higher" if delta.mean > 0 else "a is lower"
    return f"{a if (delta.mean > 0) == (way == 'higher') else b} is better"


def _metrics(table: pd.DataFrame) -> list[str]:
    return [str(name) for name in table.columns if name not in PLACE]


def text(a: Group, b: Group, compared: Sequence[Compared], tables: ClipTables) -> str:
    """Return the comparison as it is printed, with the population that its intervals are about."""
    heads = ["metric", "better", "a", "b", "a − b", f"{LEVEL:.0%} interval", "verdict"]
    body = [_row(item) for item in compared]
    widths = [max(len(row[i]) for row in [heads, *body]) for i in range(len(heads))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in [heads, *body]]
    return "\n".join([*_describe(a, b), "", *lines, "", *_notes(a, b, compared, tables), ""])


def _row(item: Compared) -> list[str]:
    delta = item.difference
    places = decimals(delta.half_width)
    return [
        item.metric,
        better(item.metric) or "unstated",
        *(plus_minus(value, decimals(value.half_width)) for value in (item.a, item.b)),
        fixed(delta.mean, places, sign=True) or "undefined",
        "none" if math.isnan(delta.low) else span(delta, places),
        item.verdict,
    ]


def _describe(a: Group, b: Group) -> list[str]:
    return [
        f"{key}: {group.label}, {_seeds(group)}, {_runs(group)}; {group.setting}" for key, group in (("a", a), ("b", b))
    ]


def _seeds(group: Group) -> str:
    if not group.seeds:
        return "not trained"
    return f"seed{'s' * (len(group.seeds) > 1)} {', '.join(group.seeds)}"


def _runs(group: Group) -> str:
    word = "evaluation" if group.runs[0].kind == "evaluation" else "run" + "s" * (len(group.runs) > 1)
    return " ".join([word, *(run.id[:SHORT] for run in group.runs)])


def _notes(a: Group, b: Group, compared: Sequence[Compared], tables: ClipTables) -> list[str]:
    most = max((item.difference for item in compared), key=lambda value: value.clips)
    about = "other scenes like these" if most.scenes > 1 else "other clips of this scene"
    paired = f"Differences are paired over {_count(most.clips, 'clip')} of {_count(most.scenes, 'scene')}"
    if most.clips == 1:
        notes = [f"{paired}: one clip has no interval and decides nothing."]
    else:
        notes = [f"± is half the {LEVEL:.0%} interval. {paired}; intervals speak about {about}."]
    for group in (a, b):
        if len(group.seeds) == 1:
            notes.append(f"{group.label} has one seed: a verdict is about these weights, not about another training.")
        elif len(group.seeds) == 2:
            notes.append(
                f"{group.label} has two seeds: they hardly tell how trainings scatter; a third narrows the interval."
            )
    if len(compared) > 1 and most.clips > 1:
        notes.append("Each interval holds on its own: of many metrics one may miss by chance.")
    if a.setting.budget and b.setting.budget and a.setting.budget != b.setting.budget:
        notes.append(f"They were trained on different budgets: {a.setting.budget} and {b.setting.budget}.")
    elif a.seeds and b.seeds and (differences := _differences(a, b)):
        notes.append(f"They also differ in {differences}.")
    clips = _clips(a, b, tables)
    for item in compared:
        left_out = clips - item.difference.clips
        if left_out:
            notes.append(f"{item.metric}: {_count(left_out, 'clip')} left out, of which not every run has a value.")
        if item.verdict == NO_INTERVAL and item.difference.clips > 1:
            notes.append(f"{item.metric} is infinite on a clip (output equals target there): no interval.")
        if better(item.metric) is None:
            notes.append(
                f"{item.metric}: no metric of the project has this name, so it is unknown which way is better."
            )
    return notes


def _count(number: int, name: str) -> str:
    return f"{number} {name}{'s' * (number != 1)}"


def _differences(a: Group, b: Group) -> str:
    """Return the settings of the training, without the model's own, in which they differ."""
    first, second = settings(a.runs[0]), settings(b.runs[0])
    names = sorted(n for n in {*first, *second} if not n.startswith("model.") and first.get(n) != second.get(n))
    return ", ".join(f"{name} ({first.get(name)}, {second.get(name)})" for name in names)


def _clips(a: Group, b: Group, tables: ClipTables) -> int:
    """Return the number of clips that stand in at least one run's table."""
    places = (tables[run.id][PLACE].itertuples(index=False, name=None) for run in [*a.runs, *b.runs])
    return len({place for rows in places for place in rows})
