"""Two methods over the same clips: each metric's paired difference, its interval, and whether the data resolve it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from supersampling.errors import UserError
from supersampling.metrics.directions import better
from supersampling.reporting.seeds import SHORT, Group
from supersampling.reporting.selection import settings
from supersampling.runs.estimates import PLACE, ClipTables, difference, estimate
from supersampling.runs.statistics import LEVEL, Estimate

NO_INTERVAL, UNRESOLVED, EQUAL = "no interval", "unresolved", "equal on every clip"


@dataclass(frozen=True)
class Compared:
    """One metric of two methods: their own means, ``a - b`` paired, and the verdict."""

    metric: str
    a: Estimate
    b: Estimate
    difference: Estimate
    verdict: str


def compare(a: Group, b: Group, tables: ClipTables, metrics: Sequence[str] | None = None) -> list[Compared]:
    """Every metric that all of both groups' runs logged, or those named, in the order of the tables.

    Raises:
        UserError: a run without clip tables, no metric or no clip in common, a metric that was not logged.
    """
    runs = [*a.runs, *b.runs]
    without = [run.id for run in runs if run.id not in tables]
    if without:
        raise UserError(f"run {without[0]} has no table of its clips: score it again with evaluate.py")
    common = [name for name in _metrics(tables[runs[0].id]) if all(name in tables[run.id] for run in runs)]
    if not common:
        raise UserError(f"'{a.label}' and '{b.label}' have no metric in common: score both with the same metrics=...")
    unknown = [name for name in metrics or () if name not in common]
    if unknown:
        raise UserError(f"metric={','.join(unknown)} was not logged by every run: choose from {', '.join(common)}")
    sides = _sides(a, b)
    found = []
    for name in metrics or common:
        own, other, delta = (
            estimate(a.runs, name, tables), estimate(b.runs, name, tables), difference(a.runs, b.runs, name, tables),
        )  # fmt: skip
        if own is None or other is None or delta is None:
            raise UserError(f"'{a.label}' and '{b.label}' have no clip in common that has a value of {name}")
        found.append(Compared(name, own, other, delta, verdict(name, delta, *sides)))
    return found


def _sides(a: Group, b: Group) -> tuple[str, str]:
    """What the verdict calls them, as short as tells them apart."""
    for one, other in ((a.runs[0].model, b.runs[0].model), (a.label, b.label)):
        if one != other:
            return one, other
    return "a", "b"


def verdict(metric: str, delta: Estimate, a: str, b: str) -> str:
    """Who is better, if the interval of ``a - b`` says so and it is known which way is better."""
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


def decimals(half_width: float) -> int:
    """So many that the half-width shows two digits; 4 where there is none."""
    if not half_width > 0 or math.isinf(half_width):
        return 4
    rounded = float(f"{half_width:.1e}")  # 9.96 becomes 10, which needs no decimal
    return min(8, max(0, 1 - math.floor(math.log10(rounded))))


def plus_minus(value: Estimate) -> str:
    """``mean ± half-width``."""
    places = decimals(value.half_width)
    mean = f"{value.mean:.{places}f}"
    return mean if math.isnan(value.half_width) else f"{mean} ± {value.half_width:.{places}f}"


def text(a: Group, b: Group, compared: Sequence[Compared], tables: ClipTables) -> str:
    """The comparison as it is printed, with what its intervals speak about."""
    heads = ["metric", "better", "a", "b", "a − b", f"{LEVEL:.0%} interval", "verdict"]
    body = [_row(item) for item in compared]
    widths = [max(len(row[i]) for row in [heads, *body]) for i in range(len(heads))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in [heads, *body]]
    return "\n".join([*_who(a, b), "", *lines, "", *_notes(a, b, compared, tables), ""])


def _row(item: Compared) -> list[str]:
    delta = item.difference
    places = decimals(delta.half_width)
    interval = "none" if math.isnan(delta.low) else f"{delta.low:+.{places}f} to {delta.high:+.{places}f}"
    mean = "undefined" if math.isnan(delta.mean) else f"{delta.mean:+.{places}f}"
    cells = [
        item.metric,
        better(item.metric) or "unstated",
        plus_minus(item.a),
        plus_minus(item.b),
        mean,
        interval,
    ]
    return [*cells, item.verdict]


def _who(a: Group, b: Group) -> list[str]:
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
    elif a.seeds and b.seeds and (other := _unlike(a, b)):
        notes.append(f"They also differ in {other}.")
    clips = _clips(a, b, tables)
    for item in compared:
        lost = clips - item.difference.clips
        if lost:
            notes.append(f"{item.metric}: {_count(lost, 'clip')} left out, of which not every run has a value.")
        if item.verdict == NO_INTERVAL and item.difference.clips > 1:
            notes.append(f"{item.metric} is infinite on a clip (output equals target there): no interval.")
        if better(item.metric) is None:
            notes.append(
                f"{item.metric}: no metric of the project has this name, so it is unknown which way is better."
            )
    return notes


def _count(number: int, name: str) -> str:
    return f"{number} {name}{'s' * (number != 1)}"


def _unlike(a: Group, b: Group) -> str:
    """Settings of the training, the model's own aside, in which they differ."""
    ours, theirs = settings(a.runs[0]), settings(b.runs[0])
    names = sorted(n for n in {*ours, *theirs} if not n.startswith("model.") and ours.get(n) != theirs.get(n))
    return ", ".join(f"{name} ({ours.get(name)}, {theirs.get(name)})" for name in names)


def _clips(a: Group, b: Group, tables: ClipTables) -> int:
    """How many clips there are in any run's table."""
    places = (tables[run.id][PLACE].itertuples(index=False, name=None) for run in [*a.runs, *b.runs])
    return len({place for listed in places for place in listed})
