"""The newest stress run: verdicts by extreme and model, frames until clean, and the growth of reprojection's errors."""

import math
from collections.abc import Sequence

import pandas as pd

from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.runs.store import Store
from supersampling.runs.tables import STRESS

ROWS_PER_SHEET = 34
SHORT = {"float32": "f32", "bfloat16": "bf16", "float16": "f16"}
# Groups of extremes with tables of their own.
APART = "recovery", "divergence"
GROWTH = {
    "static": "static",
    "to and fro 0.5": "to and fro, 1/2 px",
    "to and fro 0.25": "1/4 px",
    "one way 0.5": "one way",
    "TUS none alpha 0": "TUS alone",
    "TUS clamp_rgb alpha 0": "clamped",
    "TUS none alpha 1": "with samples",
}


def section(report: Report) -> Section | None:
    """Return the overview's page of the extremes; None for a paper, and without a stress run."""
    if report.subject is not None:
        return None
    pages = sheets(report.material.store, report.material.experiment.id)
    export(pages, report.stem)
    return Section(title="At the extremes", sheets=pages, size=7.0) if pages else None


def sheets(store: Store, experiment_id: str) -> list[Sheet]:
    """Return the sheets of the newest finished stress run; none without a run whose table can be read."""
    runs = store.logged(experiment_id, "stress", STRESS)
    if not runs:
        return []
    run, table = runs[-1]
    return typeset(table, f"Run {run.id[:12]}; {run.machine}.")


def typeset(table: pd.DataFrame, source: str) -> list[Sheet]:
    """Return all sheets of a table of `supersampling.stress.cell.Cell`."""
    group = table["extreme"].str.partition("/")[0]
    pages = _verdicts(table[~group.isin(APART)], source)
    if len(recovery := table[group == "recovery"]):
        pages.append(_recovery(recovery, source))
    if len(divergence := table[group == "divergence"]):
        pages.append(_divergence(divergence, source))
    return pages


def _verdicts(table: pd.DataFrame, source: str) -> list[Sheet]:
    models = list(dict.fromkeys(table["model"]))
    heads, compositions = _heads(models)
    groups = list(dict.fromkeys(map(_group, table["extreme"])))
    extremes = sorted(dict.fromkeys(table["extreme"]), key=lambda name: groups.index(_group(name)))
    notes = [
        "✓ holds: in every precision that was tried, finite, and within the stated tolerance of the same model in "
        "float64; its gradients are finite, too. ✗ fails in the named precisions. – not tried. Empty: does not apply "
        "to the model.",
        *compositions,
        source,
    ]
    cells = dict(list(table.groupby(["extreme", "model"])))
    rows = [[Text(extreme), *(_verdict(cells.get((extreme, model))) for model in models)] for extreme in extremes]
    pages = [range(k, min(k + ROWS_PER_SHEET, len(rows))) for k in range(0, len(rows), ROWS_PER_SHEET)]
    sheets = []
    for k, page in enumerate(pages):
        part = "" if len(pages) == 1 else f", part {k + 1} of {len(pages)}"
        sheets.append(
            Sheet(
                name=f"stress_{k + 1}",
                title=f"Every model at the extremes{part}.",
                headers=["extreme", *heads],
                rows=[rows[row] for row in page],
                notes=notes if k == len(pages) - 1 else [],
                rules=[n for n, row in enumerate(page) if row and _group(extremes[row]) != _group(extremes[row - 1])],
            )
        )
    return sheets


def _heads(models: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the columns' heads and notes.

    A head is the model's file if that is unique, else the whole composition; the rest of a composition is a note.
    """
    files = [model.partition(" ")[0] for model in models]
    heads = [file if files.count(file) == 1 else model for file, model in zip(files, models)]
    notes = [f"{head}: {model.partition(' ')[2]}." for head, model in zip(heads, models) if head != model]
    return heads, [" ".join(notes)] if notes else []


def _group(extreme: str) -> str:
    return extreme.partition("/")[0]


def _verdict(rows: pd.DataFrame | None) -> Text:
    """Return one cell for all precisions."""
    if rows is None:
        return Text("")
    failures = [SHORT.get(p, p) for p in rows.loc[rows["verdict"] == "fails", "precision"]]
    if failures:
        return Text("✗ " + " ".join(dict.fromkeys(failures)), "no")
    if (rows["verdict"] == "holds").any():
        return Text("✓ holds", "yes")
    return Text("– not tried", "muted")


def _number(value: object) -> float:
    return math.nan if value is None else float(str(value))


def _recovery(table: pd.DataFrame, source: str) -> Sheet:
    faults, models = sorted(set(table["extreme"])), list(dict.fromkeys(table["model"]))
    heads, compositions = _heads(models)
    cells = {(row["extreme"], row["model"]): row for _, row in table.iterrows()}
    notes = [
        "The number of frames, including the bad one, after which the output stays finite and within half an 8-bit "
        "step of the undisturbed roll-out. “finite”: the distance still shrinks at the end; the model's gates decide "
        "how fast a history is replaced.",
        *compositions,
        source,
    ]
    return Sheet(
        name="stress_recovery",
        title="Frames until clean after a bad one.",
        headers=["fault", *heads],
        rows=[
            [Text(fault.partition("/")[2]), *(_frames(cells.get((fault, model))) for model in models)]
            for fault in faults
        ],
        notes=notes,
    )


def _frames(row: pd.Series | None) -> Text:
    if row is None:
        return Text("")
    value = _number(row["value"])
    style: Style = "yes" if row["verdict"] == "holds" else "no"
    if math.isnan(value):
        return Text("✓ finite" if style == "yes" else "✗ never", style)
    return Text(f"✓ {value:.0f}" if style == "yes" else f"✗ {value:.0f}", style)


def _divergence(table: pd.DataFrame, source: str) -> Sheet:
    cells = {(row["model"], row["extreme"].partition("/")[2]): row for _, row in table.iterrows()}
    rows = []
    for kernel in dict.fromkeys(table["model"]):
        truth = cells.get((kernel, "to and fro 0.5"))
        gain = "" if truth is None else f"{_number(truth['truth']):.4f}"
        growth = [_growth(cells.get((kernel, motion)), motion) for motion in GROWTH]
        rows.append([Text(kernel.removeprefix("reproject=")), Text(gain), *growth])
    notes = [
        "Growth of an error per frame while the image stands still, and while it moves to and fro. Gain: the kernel's "
        "largest gain at half a pixel. One way: the largest factor while noise moves out of the image. The last "
        "three: RMS difference after a shaken roll-out of TUS that takes up no samples, with its history clamped, and "
        "with samples.",
        source,
    ]
    return Sheet(
        name="stress_divergence",
        title="The growth of reprojection's errors.",
        headers=["kernel", "gain", *GROWTH.values()],
        rows=rows,
        notes=notes,
    )


def _growth(row: pd.Series | None, motion: str) -> Text:
    if row is None:
        return Text("")
    value = _number(row["value"])
    if motion.startswith(("TUS", "one way")):
        return Text(f"{value:.3g}")
    return Text(f"{value:.4f}", "no" if value > 1.0 + 1e-6 else "plain")
