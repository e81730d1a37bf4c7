"""The advice of the overview: the newest for each scene and space, its savings and cost, and the gain of each part."""

import math
from collections.abc import Mapping
from typing import Any

import pandas as pd

from supersampling.reporting.format import fixed, span, thousands, typeset
from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Store
from supersampling.runs.tables import CONTRIBUTIONS, SUMMARY

Row = dict[str, Any]


def section(report: Report) -> Section | None:
    """Return the overview's page of advice; None for a paper, and without advice."""
    if report.subject is not None:
        return None
    pages = sheets(report.material.store, report.material.experiment.id)
    export(pages, report.stem)
    return Section(title="What scenes require", sheets=pages, size=7.5) if pages else None


def sheets(store: Store, experiment_id: str) -> list[Sheet]:
    """Return the answers, and a table of parts for each space; none without advice."""
    newest = _tables(store, experiment_id)
    if not newest:
        return []
    machines = ", ".join(sorted({machine for machine, _, _ in newest}))
    summaries = pd.concat([summary for _, summary, _ in newest], ignore_index=True)
    answers: list[Row] = summaries.sort_values(["space", "scene"]).to_dict("records")  # type: ignore[assignment]
    pages = [_answers(answers, machines), _savings(answers)]
    for space in sorted({str(row["space"]) for row in answers}):
        parts = {str(s["scene"].iloc[0]): p for _, s, p in newest if s["space"].iloc[0] == space}
        if any(len(table) for table in parts.values()):
            pages.append(_parts(space, parts))
    return pages


def _tables(store: Store, experiment_id: str) -> list[tuple[str, pd.DataFrame, pd.DataFrame]]:
    """Return machine, summary and parts of the newest finished run for each scene and space."""
    parts = {run.id: table for run, table in store.logged(experiment_id, "advice", CONTRIBUTIONS)}
    newest = {}
    for run, summary in store.logged(experiment_id, "advice", SUMMARY):
        if len(summary) and run.id in parts:
            newest[summary["scene"].iloc[0], summary["space"].iloc[0]] = (run.machine, summary, parts[run.id])
    return list(newest.values())


def _answers(rows: list[Row], machines: str) -> Sheet:
    body = [
        [
            Text(str(row["scene"])),
            Text(str(row["space"])),
            Text(_with_commas(row["chosen"])),
            Text(_interval(_estimate(row, "loss"))),
            Text(f"{row['margin']:g}"),
            Text(str(row["size"]).replace("x", "×")),
            Text(f"{row['ms']:.1f}"),
            Text(f"{row['best_ms']:.1f}"),
            Text(_count(row["unresolved"]), "open" if row["unresolved"] else "muted"),
        ]
        for row in rows
    ]
    notes = [
        "The cheapest composition whose loss against the best of the search lies within the margin at the far end of "
        "its 95% interval, paired over test clips and seeds. Open: the number of cheaper compositions whose interval "
        "does not decide; more seeds or clips would.",
        f"Milliseconds per frame in streaming use, at the rendered size: {machines}.",
    ]
    heads = ["scene", "space", "answer", "loss, dB", "margin", "rendered", "ms", "best's ms", "open"]
    return Sheet(name="advice", title="What scenes require.", headers=heads, rows=body, labels=3, notes=notes)


def _savings(rows: list[Row]) -> Sheet:
    body = [
        [
            Text(str(row["scene"])),
            Text(str(row["space"])),
            Text(str(row["left_out"]) or "none", "plain" if row["left_out"] else "muted"),
            Text(f"{row['left_out_mb']:.2f} of {row['of_mb']:.2f}"),
            Text(f"{row['trainings']} of {row['walk_trainings']}"),
            Text(f"{thousands(row['steps'])} of {thousands(row['walk_steps'])}"),
            Text(f"{row['minutes']:.0f} of {row['walk_minutes']:.0f}"),
        ]
        for row in rows
    ]
    notes = [
        "Buffers left out: those that some composition of the space reads and the answer does not; MB per frame. "
        "Trainings, optimizer steps and minutes of training: of the search, and of a walk over the whole space with "
        "the last round's trainings (its minutes in proportion to its steps)."
    ]
    return Sheet(
        name="advice_saved",
        title="What the advice saves, and what it cost.",
        headers=["scene", "space", "buffers left out", "MB", "trainings", "steps", "minutes"],
        rows=body,
        labels=3,
        notes=notes,
    )


def _parts(space: str, tables: dict[str, pd.DataFrame]) -> Sheet:
    """Return one row for each part and scene, of the last round that has a pair."""
    body: list[list[Text]] = []
    rules: list[int] = []
    for scene in sorted(tables):
        table = tables[scene]
        if not len(table):
            continue
        rules.append(len(body))
        last = table.sort_values("round", kind="stable").drop_duplicates("part", keep="last").sort_index()
        for number, row in enumerate(last.to_dict("records")):
            gain = _estimate(row, "db")
            body.append(
                [
                    Text(scene if number == 0 else ""),
                    Text(str(row["part"])),
                    Text(str(row["against"])),
                    Text(_interval(gain), _style(gain)),
                    Text(typeset(fixed(row["ms"], 1, sign=True))),
                    Text(f"{row['round']} ({row['pairs']})" if row["pairs"] else ""),
                    Text("yes" if row["kept"] else "no", "yes" if row["kept"] else "muted"),
                ]
            )
    notes = [
        "Mean paired difference over the pairs of compositions that differ only in the part, and over clips and "
        "seeds, with its 95% interval; the milliseconds per frame that the part takes; the last round with such a "
        "pair, and the number of pairs. A part that was not searched cannot matter on the scene, according to the "
        "content of its files."
    ]
    return Sheet(
        name=f"advice_{space}",
        title=f"What each part brings: the space {space}.",
        headers=["scene", "part", "against", "brings, dB", "ms", "round (pairs)", "kept"],
        rows=body,
        labels=3,
        notes=notes,
        rules=rules,
    )


def _estimate(row: Mapping[Any, Any], mean: str) -> Estimate:
    """Return the row's mean and interval; JSON's null becomes NaN."""
    numbers = (row[name] for name in (mean, "low", "high"))
    middle, low, high = (math.nan if value is None else float(value) for value in numbers)
    return Estimate(middle, low, high, clips=0)


def _style(gain: Estimate) -> Style:
    if gain.low > 0:
        return "yes"
    return "no" if gain.high < 0 else "plain"


def _interval(value: Estimate) -> str:
    if math.isnan(value.mean):
        return "not searched"
    mean = fixed(value.mean, 2, sign=True)
    return typeset(mean if math.isnan(value.low) else f"{mean} ({span(value, 2)})")


def _with_commas(name: object) -> str:
    return ", ".join(str(name).split(" "))


def _count(names: object) -> str:
    return str(len(str(names).split("; "))) if names else "0"
