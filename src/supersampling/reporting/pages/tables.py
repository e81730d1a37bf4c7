"""A paper's tables with our numbers in their cells: as sheets to typeset, and in long form."""

import math
from collections.abc import Mapping

from supersampling.reporting.format import fixed, plus_minus, span, typeset, unless_resolved
from supersampling.reporting.pages.exports import export_rows, export_words
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Style, Text
from supersampling.reporting.papers.published import name_of, stem_of, sweep_of
from supersampling.reporting.papers.schema import Metric, Paper, full_stop
from supersampling.reporting.papers.tables import NOT_RUN, Filled, ranks
from supersampling.reporting.papers.times import quantity_of
from supersampling.reporting.settings import Setting
from supersampling.runs.measurements import MS
from supersampling.runs.statistics import Estimate

# Columns of two numbers that fit a page beside each other, and of two stacked numbers.
SIDE_BY_SIDE = 4
STACKED = 6
LOST = "–"
LEADS = 4
WORDS = [
    Text(
        "Published numbers come from another data set than ours: compare differences and orders, not values. Of our "
        "numbers, the best of each comparison is set in "
    ),
    Text("bold", "bold"),
    Text(", the second of three or more is "),
    Text("underlined", "underline"),
    Text(
        ". A value’s ± is half its 95% bootstrap interval over test clips. A dash marks a number that the paper does "
        "not give, or that is lost in its text."
    ),
]
Styles = Mapping[tuple[int, int, str], Style]


def section(report: Report) -> Section | None:
    """Return a paper's tables beside our numbers; None for the overview."""
    if report.subject is None or not report.filled:
        return None
    paper = report.subject.paper
    parts = [part for filled in report.filled for part in sheets(filled, paper)]
    export_words(parts, report.stem)
    for filled in report.filled:
        export_rows(long_form(filled, paper), f"{report.stem}_table{stem_of(filled.table.number)}.csv")
    return Section(title="Beside the published tables", words=WORDS, sheets=parts, size=7.5)


def sheets(filled: Filled, paper: Paper) -> list[Sheet]:
    """Return the table to typeset: published and our numbers side by side, or below each other if the columns are many.

    A table with more columns than a page holds has several parts.
    """
    count = len(filled.table.columns)
    if count <= SIDE_BY_SIDE:
        return [_sheet(filled, paper, range(count), 0, 1)]
    parts = -(-count // STACKED)
    width = -(-count // parts)
    starts = range(0, count, width)
    return [
        _sheet(filled, paper, range(start, min(start + width, count)), part, len(starts))
        for part, start in enumerate(starts)
    ]


def _sheet(filled: Filled, paper: Paper, columns: range, part: int, parts: int) -> Sheet:
    table, styles = filled.table, _styles(filled, paper)
    stacked = len(table.columns) > SIDE_BY_SIDE
    names = table.columns[0].metrics if table.compare == "row" else [""]
    body: list[list[Text]] = []
    for index, row in enumerate(table.rows):
        for line, name in enumerate(names):
            labels = [Text(label if line == 0 else "") for label in row.labels]
            metric = [Text(metric_label(paper.metrics[name]))] if name else []
            pairs = [_pair(filled, paper, styles, index, column, line) for column in columns]
            if not stacked:
                body.append([*labels, *metric, *(text for pair in pairs for text in pair)])
                continue
            blank = [Text("") for _ in (*labels, *metric)]
            body.append([*labels, *metric, Text(paper.short, "muted"), *(published for published, _ in pairs)])
            body.append([*blank, Text("ours", "muted"), *(measured for _, measured in pairs)])
    label_heads = [*table.headers, *(["metric"] if names[0] else []), *([""] if stacked else [])]
    heads = [table.columns[column].label for column in columns]
    lines = len(body) // len(table.rows)
    return Sheet(
        name=f"table{stem_of(table.number)}" + (f"_part{part + 1}" if parts > 1 else ""),
        title=full_stop(f"{name_of(table.number)} {paper.of}" + (f", part {part + 1} of {parts}" if parts > 1 else "")),
        groups=[] if stacked else [*(("", 1) for _ in label_heads), *((label, 2) for label in heads)],
        headers=[*label_heads, *(heads if stacked else [paper.short, "ours"] * len(heads))],
        rows=body,
        labels=len(label_heads),
        notes=_notes(filled, paper) if part == 0 else [],
        rules=list(range(0, len(body), lines)) if lines > 1 else [],
    )


def metric_label(metric: Metric) -> str:
    """Return the metric's label, with its unit if it has one."""
    if metric.unit.startswith("1") or metric.unit in metric.label:
        return metric.label
    return f"{metric.label} ({metric.unit})"


def _pair(filled: Filled, paper: Paper, styles: Styles, row: int, column: int, line: int) -> tuple[Text, Text]:
    """Return the published and our text of a cell's ``line``-th metric."""
    name = filled.table.columns[column].metrics[line]
    metric = paper.metrics[name]
    number = filled.table.rows[row].values[column][line]
    published = Text(LOST, "muted") if number is None else Text(typeset(fixed(number, metric.decimals)))
    value = filled.values.get((row, column, name))
    if value is not None:
        return published, Text(typeset(plus_minus(value, metric.decimals)), styles[row, column, name])
    return published, Text(filled.state(row, column, metric), "muted")


def _styles(filled: Filled, paper: Paper) -> dict[tuple[int, int, str], Style]:
    along_row = filled.table.compare == "row"
    styles: dict[tuple[int, int, str], Style] = {}
    for group in {(row if along_row else column, name) for row, column, name in filled.values}:
        compared = {
            (row, column): value.mean
            for (row, column, name), value in filled.values.items()
            if (row if along_row else column, name) == group
        }
        ranked = ranks(compared, paper.metrics[group[1]])
        styles.update({(*place, group[1]): style for place, style in ranked.items()})
    return styles


def _notes(filled: Filled, paper: Paper) -> list[str]:
    table = filled.table
    notes = [full_stop(text) for text in (table.caption, table.note, table.lost) if text]
    sweep = sweep_of(table, paper)
    sweep_note = [f"What is not run: sweeps={sweep}."] if sweep else []
    if table.command:
        notes.append(f"Measured by “{table.command}”.")
    if filled.measured:
        notes.append(f"Ours, measured: {full_stop(filled.measured)}")
        if any(quantity_of(paper.metrics[name].logged) == MS for _, _, name in filled.values):
            notes.append("Of two machines' times only ratios compare.")
    if filled.measured and not filled.settings:
        return notes
    if not filled.settings:
        return [*notes, "Ours: not run.", *sweep_note]
    notes.append(_settings_note(filled))
    seeds = sorted({len(runs) for runs in filled.runs.values()})
    if seeds[-1] > 1:
        notes.append(f"Mean over {' to '.join(str(n) for n in sorted({seeds[0], seeds[-1]}))} seeds.")
    if table.source == "run":
        notes.append("Our numbers are those that the runs logged; they have no interval.")
    if any(paper.metrics[name].logged == "ssim_zero_pad11" for _, _, name in filled.values):
        notes.append("SSIM as the thesis's program computes it (ssim_zero_pad11).")
    if 0 < len(filled.gaps) <= LEADS:
        leads = "; ".join(f"{name} {_interval(gap)}" for name, gap in filled.gaps.items())
        notes.append(f"Lead of our best over our second PSNR in dB, paired over clips: {leads}.")
    if filled.left_out:
        notes.append(f"{len(filled.left_out)} matching runs with other settings or repeated seeds left out.")
    if any(row["state"] == NOT_RUN for row in long_form(filled, paper)):
        notes += sweep_note
    return notes


def _settings_note(filled: Filled) -> str:
    by_setting: dict[Setting, list[str]] = {}
    for row, setting in sorted(filled.settings.items()):
        by_setting.setdefault(setting, []).append("/".join(filled.table.rows[row].labels))
    if len(by_setting) == 1:
        return f"Ours: {next(iter(by_setting))}."
    return "Ours: " + "; ".join(f"row {', '.join(rows)}: {key}" for key, rows in by_setting.items()) + "."


def _interval(gap: Estimate) -> str:
    if math.isnan(gap.low):
        return f"{fixed(gap.mean, 2)} without interval"
    return typeset(f"{fixed(gap.mean, 2)} ({span(gap, 2, sign=False)}{unless_resolved(gap)})")


def long_form(filled: Filled, paper: Paper) -> list[dict[str, object]]:
    """Return one row per number of the table: published, ours, half-width and the runs behind it."""
    rows: list[dict[str, object]] = []
    for index, row in enumerate(filled.table.rows):
        for place, column in enumerate(filled.table.columns):
            runs = filled.runs.get((index, place), [])
            setting = filled.settings.get(index)
            for line, name in enumerate(column.metrics):
                metric, value = paper.metrics[name], filled.values.get((index, place, name))
                rows.append(
                    {
                        "table": filled.table.number,
                        "row": "/".join(row.labels),
                        "column": column.label,
                        "metric": metric.label,
                        "unit": metric.unit,
                        "published": row.values[place][line],
                        "ours": value.mean if value else None,
                        "half_width_95": value.half_width if value else None,
                        "clips": value.clips if value else None,
                        "seeds": len(runs),
                        "state": "run" if value else filled.state(index, place, metric),
                        "setting": str(setting) if runs else "",
                        "runs": " ".join(run.id for run in runs),
                    }
                )
    return rows
