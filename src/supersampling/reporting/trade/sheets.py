"""Quality against time in a report: what benchmarks logged, joined with the quality of a data set's methods."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from supersampling.reporting.pages.overview import Method
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.reporting.papers.tables import number
from supersampling.reporting.trade import front, pick
from supersampling.reporting.trade.front import Candidate, Place
from supersampling.runs import drift
from supersampling.runs.estimates import ClipTables
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Experiment, Store
from supersampling.runs.timing import STAGES, TABLE, Timing, timings_of

NOT_MEASURED = "No times of these methods were measured yet: python benchmark.py run=all measures them."
PLACES = 4
LONG = 40  # rows


@dataclass(frozen=True)
class Trade:
    """Everything that benchmarks say of a data set's methods."""

    found: list[Candidate]
    timings: list[Timing]
    stages: pd.DataFrame
    changes: list[drift.Change]
    clips: ClipTables

    @property
    def places(self) -> list[Place]:
        """Those with most times first, as many as a report shows."""
        return front.places(self.found)[:PLACES]

    def at(self, place: Place) -> list[Candidate]:
        """Its candidates, fastest first; of many the fastest way to run each method in each precision."""
        every = [c for c in self.found if Place.of(c.timing) == place]
        every = every if len(every) <= LONG else pick.distinct(every)
        return sorted(every, key=lambda c: (c.ms, c.label, c.how))

    def gap(self, a: Candidate, b: Candidate) -> Estimate | None:
        return front.gap(a, b, self.clips)


def read(store: Store, experiment: Experiment, methods: Sequence[Method], clips: ClipTables) -> Trade:
    """What the benchmarks of an experiment say of these methods; of several times of one thing the newest counts."""
    tables = [table for _, table in store.logged(experiment.id, "benchmark", TABLE)]
    timings = [timing for table in tables for timing in timings_of(table)]
    if not timings:
        return Trade([], [], pd.DataFrame(), [], clips)
    known = front.architectures([run for method in methods for run in method.runs], store)
    ours = [timing for timing in timings if timing.architecture in known.values()]
    stages, precision = (
        _joined([table for _, table in store.logged(experiment.id, "benchmark", name)], known)
        for name in (STAGES, drift.TABLE)
    )
    # An architecture is one thing, whatever the runs of it are called.
    changes = drift.changes(_newest(precision, [key for key in drift.KEYS if key != "method"]))
    found = front.candidates(methods, ours, known, clips, drift.costs(changes))
    return Trade(found, ours, stages, changes, clips)


def _joined(tables: Sequence[pd.DataFrame], known: Mapping[str, str]) -> pd.DataFrame:
    if not tables:
        return pd.DataFrame(columns=drift.KEYS)
    every = pd.concat([table.assign(order=k) for k, table in enumerate(tables)], ignore_index=True)
    return every[every["architecture"].isin(set(known.values()))]


def _newest(rows: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Of several tables that hold the same ``keys``, the last one's rows."""
    if rows.empty:
        return rows
    return rows[rows["order"] == rows.groupby(keys)["order"].transform("max")]


def sheets(trade: Trade) -> list[Sheet]:
    """The front of every place, what a frame's time is made of, what precision costs, and what does not run."""
    made = [_front_sheet(trade, place, index) for index, place in enumerate(trade.places)]
    made += [_precision_sheet(trade)] if trade.changes else []
    made += [_stage_sheet(trade)] if len(trade.stages) else []
    missing = [timing for timing in trade.timings if not timing.runs]
    return made + ([_missing_sheet(missing)] if missing else [])


def best_of(found: Sequence[Candidate]) -> Candidate:
    """The one with the highest mean; of equal ones the fastest."""
    return max(found, key=lambda c: (c.quality.mean, -c.ms))


def _front_sheet(trade: Trade, place: Place, index: int) -> Sheet:
    found = trade.at(place)
    on = {id(c) for c in front.front(found)}
    best = best_of(found)
    heads = [
        "method",
        "backend",
        "precision",
        "ms a frame",
        "PSNR (dB)",
        "Δ to the best (dB)",
        "",
        "GMAC",
        "MB",
    ]
    rows = [_front_row(trade, one, best, id(one) in on) for one in found]
    clips = max(c.quality.clips for c in found)
    notes = [
        f"{place}; batch 1, one frame at a time with its state. Median, and its quartiles in brackets.",
        f"PSNR: mean over {clips} test clips ± half the 95% interval over scenes and seeds; of a lower precision with what "
        "that was measured to cost. Δ is paired over clips, and so far narrower.",
        "“front”: no other is as fast and better, or as good and faster, by their means.",
    ]
    if len(found) < sum(Place.of(c.timing) == place for c in trade.found):
        notes.append("Of each method and precision the fastest backend stands here; the CSV file has all.")
    name = "trade" if index == 0 else f"trade_{index + 1}"
    return Sheet(name, "Quality against time.", [], heads, rows, 3, notes)


def _front_row(trade: Trade, one: Candidate, best: Candidate, on: bool) -> list[Text]:
    style: Style = "bold" if on else "plain"
    timing, gap = one.timing, trade.gap(one, best)
    spread = f" ({_ms(timing.low)}–{_ms(timing.high)})" if math.isfinite(timing.low) else ""
    return [
        Text(one.label, style),
        Text(timing.backend),
        Text(timing.precision),
        Text(_ms(one.ms) + spread),
        Text(number(one.quality, 2)),
        Text("best", "muted") if one.same == best.same else _paired(gap),
        Text("front", "bold") if on else Text(""),
        Text(_plain(timing.gmac, 2)),
        Text(_plain(timing.peak_mb, 0)),
    ]


def _paired(gap: Estimate | None) -> Text:
    if gap is None:
        return Text("")
    text = number(gap, 2, sign=True)
    return Text(text) if gap.resolved else Text(f"{text}, unresolved", "muted")


def _precision_sheet(trade: Trade) -> Sheet:
    rows = [
        [
            Text(c.method),
            Text(c.backend),
            Text(c.precision),
            Text(_signed(c.mean)),
            Text(_signed(c.slope)),
            Text("not finite" if math.isinf(c.largest) else f"{c.largest:.2g}"),
            Text(str(c.frames)),
        ]
        for c in sorted(trade.changes, key=lambda c: (c.method, c.precision, c.backend))
    ]
    heads = [
        "method", "backend", "precision", "Δ PSNR (dB)", "drift (dB a frame)", "largest difference", "frames",
    ]  # fmt: skip
    notes = [
        "Against the same weights in PyTorch's float32, both over whole clips with a state of their own: paired, ± half the 95% "
        "interval over scenes. Drift is the slope of a straight line through each clip's differences. The largest difference "
        "is of any pixel of any frame, of a range of 1."
    ]
    return Sheet("precision", "What backends and precisions change.", [], heads, rows, 3, notes)


def _stage_sheet(trade: Trade) -> Sheet:
    """The newest parts of each method in one backend, the main place's."""
    first = trade.places[0] if trade.places else None
    rows: list[list[Text]] = []
    rules: list[int] = []
    for (method, _), of_one in trade.stages.groupby(["method", "architecture"], sort=False):
        here = of_one[_here(of_one, first)] if first is not None and _here(of_one, first).any() else of_one
        last = here.iloc[-1]
        same = ["width", "height", "backend", "precision", "machine"]
        chosen = here[(here[same] == last[same]).all(axis=1)].drop_duplicates("part", keep="last")
        rules.append(len(rows))
        for k, part in enumerate(chosen.to_dict("records")):
            where = f"{part['backend']} {part['precision']}, {part['width']}x{part['height']}"
            rows.append(
                [
                    Text(str(method) if k == 0 else ""),
                    Text(where if k == 0 else ""),
                    Text(str(part["part"])),
                    Text(_ms(float(part["ms"]))),
                    Text(f"{float(part['share']):.0%}"),
                ]
            )
    heads = ["method", "how", "part", "ms", "share"]
    notes = [f"{first.machine}." if first is not None else ""]
    return Sheet("stages", "What a frame's time is made of.", [], heads, rows, 3, [n for n in notes if n], rules)


def _here(stages: pd.DataFrame, place: Place) -> pd.Series:
    return (stages["width"] == place.width) & (stages["height"] == place.height)


def _missing_sheet(missing: Sequence[Timing]) -> Sheet:
    by_reason: dict[tuple[str, str, str], list[str]] = {}
    for t in missing:
        names = by_reason.setdefault((t.backend, t.precision, t.reason), [])
        if t.method not in names:
            names.append(t.method)
    rows = [[Text(b), Text(p), Text(why), Text(", ".join(names))] for (b, p, why), names in by_reason.items()]
    return Sheet("not_timed", "What has no time.", [], ["backend", "precision", "why", "methods"], rows, 4)


def long_form(trade: Trade) -> list[dict[str, object]]:
    """A row for each candidate: time, quality and the runs behind it."""
    on = {
        id(c)
        for place in front.places(trade.found)
        for c in front.front([c for c in trade.found if Place.of(c.timing) == place])
    }
    return [
        {
            "method": c.label, **{k: v for k, v in vars(c.timing).items() if k not in ("method", "reason")},
            "psnr": c.quality.mean, "low_95": c.quality.low, "high_95": c.quality.high,
            "precision_cost": c.cost.mean if c.cost else 0.0, "front": id(c) in on,
            "runs": " ".join(run.id for run in c.runs),
        }
        for c in trade.found
    ]  # fmt: skip


def _ms(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _plain(value: float, decimals: int) -> str:
    return "" if math.isnan(value) else f"{value:.{decimals}f}"


def _signed(value: Estimate) -> str:
    return number(value, 4, sign=True)
