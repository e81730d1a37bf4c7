"""Quality against time in a report: what benchmarks logged, joined with the quality of a data set's methods."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import pandas as pd

from supersampling.reporting.format import fixed, plus_minus, short, typeset, unless_resolved
from supersampling.reporting.methods import Method
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.reporting.trade import front, pick
from supersampling.reporting.trade.front import Candidate, Place
from supersampling.runs import drift
from supersampling.runs.estimates import ClipTables
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import FinishedRuns, Store
from supersampling.runs.timing import STAGES, TABLE, Timing, timings_of

PLACES = 4
MANY_ROWS = 40


@dataclass(frozen=True, kw_only=True)
class Trade:
    """Everything that benchmarks say of a data set's methods."""

    candidates: list[Candidate]
    timings: list[Timing]
    stages: pd.DataFrame
    changes: list[drift.Change]
    clips: ClipTables

    @property
    def places(self) -> list[Place]:
        """The places with most times first, as many as a report shows."""
        return front.places(self.candidates)[:PLACES]

    def at_place(self, place: Place) -> list[Candidate]:
        """Return a place's candidates, fastest first.

        Of more than `MANY_ROWS` only the fastest way to run each method in each precision.
        """
        candidates = [c for c in self.candidates if Place.of(c.timing) == place]
        candidates = candidates if len(candidates) <= MANY_ROWS else pick.distinct(candidates)
        return sorted(candidates, key=lambda c: (c.ms, c.label, c.how))

    def gap(self, a: Candidate, b: Candidate) -> Estimate | None:
        """Return ``a - b`` paired over clips; None without common clips."""
        return front.gap(a, b, self.clips)


def read_trade(store: Store, experiment: FinishedRuns, methods: Sequence[Method], clips: ClipTables) -> Trade:
    """Return what an experiment's benchmarks say of these methods; of repeated measurements the newest counts."""
    tables = [table for _, table in store.logged(experiment.id, "benchmark", TABLE)]
    timings = [timing for table in tables for timing in timings_of(table)]
    if not timings:
        return Trade(candidates=[], timings=[], stages=pd.DataFrame(), changes=[], clips=clips)
    known = front.architectures([run for method in methods for run in method.runs], store)
    timings = [replace(timing, architecture=known.current(timing.architecture)) for timing in timings]
    timings = [timing for timing in timings if timing.architecture in known.known]
    stages, precision = (
        _joined([table for _, table in store.logged(experiment.id, "benchmark", name)], known)
        for name in (STAGES, drift.TABLE)
    )
    # The runs of an architecture may have several names.
    changes = drift.changes(_newest(precision, [key for key in drift.KEYS if key != "method"]))
    candidates = front.list_candidates(methods, timings, known.by_run, clips, drift.costs(changes))
    return Trade(candidates=candidates, timings=timings, stages=stages, changes=changes, clips=clips)


def _joined(tables: Sequence[pd.DataFrame], known: front.Architectures) -> pd.DataFrame:
    """Return the rows of the known architectures, with their table's number as ``order``."""
    if not tables:
        return pd.DataFrame(columns=drift.KEYS)
    rows = pd.concat([table.assign(order=k) for k, table in enumerate(tables)], ignore_index=True)
    rows["architecture"] = rows["architecture"].map(known.current)
    return rows[rows["architecture"].isin(known.known)]


def _newest(rows: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Return the last table's rows for each combination of ``keys``."""
    if rows.empty:
        return rows
    return rows[rows["order"] == rows.groupby(keys)["order"].transform("max")]


def sheets(trade: Trade) -> list[Sheet]:
    """Return the front of every place, what a frame's time is made of, what precision costs, and what does not run."""
    pages = [_front_sheet(trade, place, index) for index, place in enumerate(trade.places)]
    pages += [_precision_sheet(trade)] if trade.changes else []
    pages += [_stage_sheet(trade)] if len(trade.stages) else []
    missing = [timing for timing in trade.timings if not timing.runs]
    return pages + ([_missing_sheet(missing)] if missing else [])


def best_of(candidates: Sequence[Candidate]) -> Candidate:
    """Return the candidate with the highest mean; of equal ones the fastest."""
    return max(candidates, key=lambda c: (c.quality.mean, -c.ms))


def _front_sheet(trade: Trade, place: Place, index: int) -> Sheet:
    candidates = trade.at_place(place)
    on_front = {id(c) for c in front.front(candidates)}
    best = best_of(candidates)
    clips = max(c.quality.clips for c in candidates)
    notes = [
        f"{place}; batch 1, one frame at a time with its state. Median, and its quartiles in brackets.",
        f"PSNR: mean over {clips} test clips ± half the 95% interval over scenes and seeds; that of a lower precision "
        "includes its measured cost. Δ is paired over clips, so its interval is much narrower.",
        "“front”: no other is as fast and better, or as good and faster, by their means.",
    ]
    if len(candidates) < sum(Place.of(c.timing) == place for c in trade.candidates):
        notes.append("Only the fastest backend of each method and precision is listed; the CSV file has all.")
    return Sheet(
        name="trade" if index == 0 else f"trade_{index + 1}",
        title="Quality against time.",
        headers=["method", "backend", "precision", "ms a frame", "PSNR (dB)", "Δ to the best (dB)", "", "GMAC", "MB"],
        rows=[_front_row(trade, c, best, id(c) in on_front) for c in candidates],
        labels=3,
        notes=notes,
    )


def _front_row(trade: Trade, candidate: Candidate, best: Candidate, on_front: bool) -> list[Text]:
    style: Style = "bold" if on_front else "plain"
    timing = candidate.timing
    quartiles = f" ({short(timing.low)}–{short(timing.high)})" if math.isfinite(timing.low) else ""
    return [
        Text(candidate.label, style),
        Text(timing.backend),
        Text(timing.precision),
        Text(short(candidate.ms) + quartiles),
        Text(typeset(plus_minus(candidate.quality, 2))),
        Text("best", "muted") if candidate.images == best.images else _paired(trade.gap(candidate, best)),
        Text("front", "bold") if on_front else Text(""),
        Text(fixed(timing.gmac, 2)),
        Text(fixed(timing.peak_mb, 0)),
    ]


def _paired(gap: Estimate | None) -> Text:
    if gap is None:
        return Text("")
    text = typeset(plus_minus(gap, 2, sign=True))
    return Text(text + unless_resolved(gap), "plain" if gap.resolved else "muted")


def _precision_sheet(trade: Trade) -> Sheet:
    rows = [
        [
            Text(c.method),
            Text(c.backend),
            Text(c.precision),
            Text(typeset(plus_minus(c.mean, 4, sign=True))),
            Text(typeset(plus_minus(c.slope, 4, sign=True))),
            Text("not finite" if math.isinf(c.largest) else f"{c.largest:.2g}"),
            Text(str(c.frames)),
        ]
        for c in sorted(trade.changes, key=lambda c: (c.method, c.precision, c.backend))
    ]
    notes = [
        "Differences to the same weights in PyTorch's float32, each over whole clips with its own state: paired, ± "
        "half the 95% interval over scenes. Drift is the slope of a straight line through each clip's differences. "
        "The largest difference is that of any pixel of any frame, in a range of 1."
    ]
    return Sheet(
        name="precision",
        title="What backends and precisions change.",
        headers=["method", "backend", "precision", "Δ PSNR (dB)", "drift (dB a frame)", "largest difference", "frames"],
        rows=rows,
        labels=3,
        notes=notes,
    )


def _stage_sheet(trade: Trade) -> Sheet:
    """Return the newest parts of each method in one backend, at the main place if they were timed there."""
    first = trade.places[0] if trade.places else None
    rows: list[list[Text]] = []
    rules: list[int] = []
    for (method, _), stages in trade.stages.groupby(["method", "architecture"], sort=False):
        there = stages[_is_at(stages, first)] if first is not None and _is_at(stages, first).any() else stages
        last = there.iloc[-1]
        keys = ["width", "height", "backend", "precision", "machine"]
        newest = there[(there[keys] == last[keys]).all(axis=1)].drop_duplicates("part", keep="last")
        rules.append(len(rows))
        for k, part in enumerate(newest.to_dict("records")):
            how = f"{part['backend']} {part['precision']}, {part['width']}x{part['height']}"
            rows.append(
                [
                    Text(str(method) if k == 0 else ""),
                    Text(how if k == 0 else ""),
                    Text(str(part["part"])),
                    Text(short(float(part["ms"]))),
                    Text(f"{float(part['share']):.0%}"),
                ]
            )
    return Sheet(
        name="stages",
        title="What a frame's time is made of.",
        headers=["method", "how", "part", "ms", "share"],
        rows=rows,
        labels=3,
        notes=[f"{first.machine}."] if first is not None else [],
        rules=rules,
    )


def _is_at(stages: pd.DataFrame, place: Place) -> pd.Series:
    return (stages["width"] == place.width) & (stages["height"] == place.height)


def _missing_sheet(missing: Sequence[Timing]) -> Sheet:
    by_reason: dict[tuple[str, str, str], list[str]] = {}
    for t in missing:
        names = by_reason.setdefault((t.backend, t.precision, t.reason), [])
        if t.method not in names:
            names.append(t.method)
    return Sheet(
        name="not_timed",
        title="Methods without a time.",
        headers=["backend", "precision", "why", "methods"],
        rows=[[*map(Text, reason), Text(", ".join(names))] for reason, names in by_reason.items()],
        labels=4,
    )


def long_form(trade: Trade) -> list[dict[str, object]]:
    """Return one row per candidate: time, quality and the runs behind it."""
    on_front = {
        id(c)
        for place in front.places(trade.candidates)
        for c in front.front([c for c in trade.candidates if Place.of(c.timing) == place])
    }
    return [
        {
            "method": c.label,
            **{k: v for k, v in vars(c.timing).items() if k not in ("method", "reason")},
            "psnr": c.quality.mean,
            "low_95": c.quality.low,
            "high_95": c.quality.high,
            "precision_cost": c.cost.mean if c.cost else 0.0,
            "front": id(c) in on_front,
            "runs": " ".join(run.id for run in c.runs),
        }
        for c in trade.candidates
    ]
