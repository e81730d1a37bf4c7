"""The newest stress run as pages: verdicts by extreme and model, frames until clean, and cubic reprojection's growth."""

import math
from collections.abc import Sequence

import pandas as pd

from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.runs.store import Store
from supersampling.runs.tables import STRESS

ROWS_A_SHEET = 34
SHORT = {"float32": "f32", "bfloat16": "bf16", "float16": "f16"}
APART = "recovery", "divergence"  # groups with tables of their own
GROWTH = {
    "static": "static", "to and fro 0.5": "to and fro, 1/2 px", "to and fro 0.25": "1/4 px", "one way 0.5": "one way",
    "TUS none alpha 0": "TUS alone", "TUS clamp_rgb alpha 0": "clamped", "TUS none alpha 1": "with samples",
}  # fmt: skip


def sheets(store: Store, experiment_id: str) -> list[Sheet]:
    """Those of the newest finished stress run; none where there is no such run, or its table cannot be read."""
    found = store.logged(experiment_id, "stress", STRESS)
    if not found:
        return []
    run, table = found[-1]
    return typeset(table, f"Run {run.id[:12]}; {run.machine}.")


def typeset(table: pd.DataFrame, source: str) -> list[Sheet]:
    """All sheets of a table of `supersampling.stress.cell.Cell`."""
    group = table["extreme"].str.partition("/")[0]
    made = _verdicts(table[~group.isin(APART)], source)
    if len(recovery := table[group == "recovery"]):
        made.append(_recovery(recovery, source))
    if len(divergence := table[group == "divergence"]):
        made.append(_divergence(divergence, source))
    return made


def _verdicts(table: pd.DataFrame, source: str) -> list[Sheet]:
    models = list(dict.fromkeys(table["model"]))
    heads, composed = _heads(models)
    groups = list(dict.fromkeys(map(_group, table["extreme"])))
    extremes = sorted(dict.fromkeys(table["extreme"]), key=lambda name: groups.index(_group(name)))
    notes = [
        "✓ holds: finite, and within the stated tolerance of the same model in float64, in every precision that was tried; its "
        "gradients are finite, too. ✗ fails in the precisions named. – not tried. Empty: the model has nothing of the kind.",
        *composed,
        source,
    ]
    by = dict(list(table.groupby(["extreme", "model"])))
    rows = [[Text(extreme), *(_verdict(by.get((extreme, model))) for model in models)] for extreme in extremes]
    pages = [range(k, min(k + ROWS_A_SHEET, len(rows))) for k in range(0, len(rows), ROWS_A_SHEET)]
    made = []
    for k, page in enumerate(pages):
        starts = [n for n, at in enumerate(page) if at and _group(extremes[at]) != _group(extremes[at - 1])]
        part = "" if len(pages) == 1 else f", part {k + 1} of {len(pages)}"
        made.append(
            Sheet(
                f"stress_{k + 1}",
                f"Every model at the extremes{part}.",
                [],
                ["extreme", *heads],
                [rows[at] for at in page],
                1,
                notes if k == len(pages) - 1 else [],
                starts,
            )
        )
    return made


def _heads(models: Sequence[str]) -> tuple[list[str], list[str]]:
    """A model's file for a column's head where that says which it is; what else it was composed of is a note."""
    files = [model.partition(" ")[0] for model in models]
    heads = [file if files.count(file) == 1 else model for file, model in zip(files, models)]
    more = [f"{head}: {model.partition(' ')[2]}." for head, model in zip(heads, models) if head != model]
    return heads, [" ".join(more)] if more else []


def _group(extreme: str) -> str:
    return extreme.partition("/")[0]


def _verdict(rows: pd.DataFrame | None) -> Text:
    """One cell for all precisions."""
    if rows is None:
        return Text("")
    failed = [SHORT.get(p, p) for p in rows.loc[rows["verdict"] == "fails", "precision"]]
    if failed:
        return Text("✗ " + " ".join(dict.fromkeys(failed)), "no")
    if (rows["verdict"] == "holds").any():
        return Text("✓ holds", "yes")
    return Text("– not tried", "muted")


def _number(value: object) -> float:
    return math.nan if value is None else float(str(value))


def _recovery(table: pd.DataFrame, source: str) -> Sheet:
    faults, models = sorted(set(table["extreme"])), list(dict.fromkeys(table["model"]))
    heads, composed = _heads(models)
    by = {(row["extreme"], row["model"]): row for _, row in table.iterrows()}
    rows = [[Text(fault.partition("/")[2]), *(_frames(by.get((fault, model))) for model in models)] for fault in faults]
    notes = [
        "Frames, the bad one among them, until the output is finite and half a step of 8 bits from the undisturbed roll-out, for "
        "good. “finite” where the distance still shrinks at the end: how fast a history is replaced, the model's gates say.",
        *composed,
        source,
    ]
    return Sheet("stress_recovery", "Frames until clean after a bad one.", [], ["fault", *heads], rows, 1, notes)


def _frames(row: pd.Series | None) -> Text:
    if row is None:
        return Text("")
    value = _number(row["value"])
    style: Style = "yes" if row["verdict"] == "holds" else "no"
    if math.isnan(value):
        return Text("✓ finite" if style == "yes" else "✗ never", style)
    return Text(f"✓ {value:.0f}" if style == "yes" else f"✗ {value:.0f}", style)


def _divergence(table: pd.DataFrame, source: str) -> Sheet:
    kernels: Sequence[str] = list(dict.fromkeys(table["model"]))
    by = {(row["model"], row["extreme"].partition("/")[2]): row for _, row in table.iterrows()}
    rows = []
    for kernel in kernels:
        cells = [_growth(by.get((kernel, what)), what) for what in GROWTH]
        truth = by.get((kernel, "to and fro 0.5"))
        gain = "" if truth is None else f"{_number(truth['truth']):.4f}"
        rows.append([Text(kernel.removeprefix("reproject=")), Text(gain), *cells])
    notes = [
        "Growth per frame of an error while the image stands, and moves to and fro; beside it the kernel's largest gain at half "
        "a pixel. One way: the largest factor while noise moves out of the image. The last three: RMS difference after a shaken "
        "roll-out of TUS that takes up no samples, with its history clamped, and with samples.",
        source,
    ]
    return Sheet(
        "stress_divergence",
        "The growth of reprojection's errors.",
        [],
        ["kernel", "gain", *GROWTH.values()],
        rows,
        1,
        notes,
    )


def _growth(row: pd.Series | None, what: str) -> Text:
    if row is None:
        return Text("")
    value = _number(row["value"])
    if what.startswith(("TUS", "one way")):
        return Text(f"{value:.3g}")
    return Text(f"{value:.4f}", "no" if value > 1.0 + 1e-6 else "plain")
