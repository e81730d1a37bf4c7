"""What scenes require: of each scene and space the newest advice, what it saves, what it took, and what each part brings."""

import math
from typing import Any

import pandas as pd

from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.runs.store import Store
from supersampling.runs.tables import CONTRIBUTIONS, SUMMARY


def sheets(store: Store, experiment_id: str) -> list[Sheet]:
    """The answers, and a table of parts for each space; none where nobody asked for advice."""
    found = _tables(store, experiment_id)
    if not found:
        return []
    machines = ", ".join(sorted({machine for machine, _, _ in found}))
    joined = pd.concat([summary for _, summary, _ in found], ignore_index=True)
    answers: list[dict[str, Any]] = joined.sort_values(["space", "scene"]).to_dict("records")  # type: ignore[assignment]
    made = [_answers(answers, machines), _saved(answers)]
    for space in sorted({str(row["space"]) for row in answers}):
        parts = {str(s["scene"].iloc[0]): p for _, s, p in found if s["space"].iloc[0] == space}
        if any(len(table) for table in parts.values()):
            made.append(_parts(space, parts))
    return made


def _tables(store: Store, experiment_id: str) -> list[tuple[str, pd.DataFrame, pd.DataFrame]]:
    """Machine, summary and parts of the newest finished run of each scene and space."""
    parts = {run.id: table for run, table in store.logged(experiment_id, "advice", CONTRIBUTIONS)}
    newest = {}
    for run, summary in store.logged(experiment_id, "advice", SUMMARY):
        if len(summary) and run.id in parts:
            newest[summary["scene"].iloc[0], summary["space"].iloc[0]] = (run.machine, summary, parts[run.id])
    return list(newest.values())


def _answers(rows: list[dict[str, Any]], machines: str) -> Sheet:
    body = [
        [
            Text(str(row["scene"])),
            Text(str(row["space"])),
            Text(_spaced(row["chosen"])),
            Text(_interval(row["loss"], row["low"], row["high"])),
            Text(f"{row['margin']:g}"),
            Text(str(row["size"]).replace("x", "×")),
            Text(f"{row['ms']:.1f}"),
            Text(f"{row['best_ms']:.1f}"),
            Text(_count(row["unresolved"]), "open" if row["unresolved"] else "muted"),
        ]
        for row in rows
    ]
    notes = [
        "The cheapest composition whose loss against the best of the search lies within the margin by the end of its 95% "
        "interval, paired over test clips and seeds. Open: cheaper ones of which the interval says neither; more seeds or clips "
        "would tell.",
        f"Milliseconds a frame in streaming use, of so many rendered pixels: {machines}.",
    ]
    heads = ["scene", "space", "answer", "loss, dB", "margin", "rendered", "ms", "best's ms", "open"]
    return Sheet("advice", "What scenes require.", [], heads, body, 3, notes)


def _saved(rows: list[dict[str, Any]]) -> Sheet:
    body = [
        [
            Text(str(row["scene"])),
            Text(str(row["space"])),
            Text(str(row["left_out"]) or "none", "plain" if row["left_out"] else "muted"),
            Text(f"{row['left_out_mb']:.2f} of {row['of_mb']:.2f}"),
            Text(f"{row['trainings']} of {row['walk_trainings']}"),
            Text(f"{_thousands(row['steps'])} of {_thousands(row['walk_steps'])}"),
            Text(f"{row['minutes']:.0f} of {row['walk_minutes']:.0f}"),
        ]
        for row in rows
    ]
    notes = [
        "Buffers are those that some composition of the space reads and the answer does not; MB a frame. Trainings, optimizer "
        "steps and minutes of training: of the search, and of a walk over the whole space by the last round's trainings (its "
        "minutes in proportion to its steps)."
    ]
    heads = ["scene", "space", "buffers left out", "MB", "trainings", "steps", "minutes"]
    return Sheet("advice_saved", "What the advice saves, and what it took.", [], heads, body, 3, notes)


def _parts(space: str, tables: dict[str, pd.DataFrame]) -> Sheet:
    """A row for each part and scene, of the last round that has a pair."""
    body: list[list[Text]] = []
    rules: list[int] = []
    for scene in sorted(tables):
        table = tables[scene]
        if not len(table):
            continue
        rules.append(len(body))
        last = table.sort_values("round", kind="stable").drop_duplicates("part", keep="last").sort_index()
        for number, row in enumerate(last.to_dict("records")):
            body.append(
                [
                    Text(scene if number == 0 else ""),
                    Text(str(row["part"])),
                    Text(str(row["against"])),
                    Text(_interval(row["db"], row["low"], row["high"]), _style(row["low"], row["high"])),
                    Text(f"{row['ms']:+.1f}".replace("-", "−")),
                    Text(f"{row['round']} ({row['pairs']})" if row["pairs"] else ""),
                    Text("yes" if row["kept"] else "no", "yes" if row["kept"] else "muted"),
                ]
            )
    notes = [
        "Mean paired difference over the pairs of compositions that differ in the part alone, and over clips and seeds, with its "
        "95% interval; milliseconds a frame that it takes; the last round that has such a pair, and how many. What was not "
        "searched cannot matter on the scene by what its files hold."
    ]
    heads = ["scene", "part", "against", "brings, dB", "ms", "round (pairs)", "kept"]
    title = f"What each part brings: the space {space}."
    return Sheet(f"advice_{space}", title, [], heads, body, 3, notes, rules)


def _style(low: object, high: object) -> Style:
    if _number(low) > 0:
        return "yes"
    return "no" if _number(high) < 0 else "plain"


def _number(value: object) -> float:
    return math.nan if value is None else float(str(value))


def _interval(mean: object, low: object, high: object) -> str:
    if math.isnan(_number(mean)):
        return "not searched"
    text = f"{_number(mean):+.2f}"
    if not math.isnan(_number(low)):
        text += f" ({_number(low):+.2f} to {_number(high):+.2f})"
    return text.replace("-", "−")


def _spaced(name: object) -> str:
    return ", ".join(str(name).split(" "))


def _count(names: object) -> str:
    return str(len(str(names).split("; "))) if names else "0"


def _thousands(value: object) -> str:
    return f"{int(_number(value)):,}".replace(",", " ")
