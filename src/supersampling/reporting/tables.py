"""A paper's table with our numbers in its cells, as a sheet to typeset and as long-form rows."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from supersampling.reporting.estimates import ClipTables, difference, estimate, scaled
from supersampling.reporting.published import Metric, Paper, PublishedTable, Selection
from supersampling.reporting.runs import Run
from supersampling.reporting.selection import Choice, Chosen, Setting, choose_runs, pool_for
from supersampling.reporting.sheet import Sheet, Style, Text
from supersampling.reporting.statistics import Estimate

NOT_RUN, NOT_AVAILABLE = "not run", "not available"
Place = tuple[int, int]


@dataclass(frozen=True)
class Filled:
    """A published table's cells ``(row, column)`` that our runs fill, and each row's setting.

    ``gaps`` holds, by the name of a comparison, how far the best PSNR leads the second, paired over clips.
    """

    table: PublishedTable
    settings: dict[int, Setting]
    runs: dict[Place, list[Run]]
    values: dict[tuple[int, int, str], Estimate]
    left_out: list[Run]
    gaps: dict[str, Estimate]


def fill(table: PublishedTable, paper: Paper, choice: Choice, tables: ClipTables) -> Filled:
    """Find our runs for each cell. Cells that are compared (along a row or a column) share one setting."""
    rows = range(len(table.rows))
    groups = [[row] for row in rows] if table.compare == "row" else [list(rows)]
    filled = Filled(table, {}, {}, {}, [], {})
    for group in groups:
        selections = _selections(table, group)
        pool = pool_for(choice, selections.values(), table.prefer or {})
        if pool is None:
            continue
        chosen: Chosen[Place] = choose_runs(pool[1], selections)
        filled.settings.update(dict.fromkeys(group, pool[0]))
        filled.runs.update({place: runs for place, runs in chosen.cells.items() if runs})
        filled.left_out.extend(chosen.left_out)
        gap = _gap(chosen.cells, tables)
        if gap is not None:
            filled.gaps["/".join(table.rows[group[0]].labels) if table.compare == "row" else "PSNR"] = gap
    for (row, column), runs in filled.runs.items():
        for name in table.columns[column].metrics:
            value = estimate(runs, paper.metrics[name].ours, tables)
            if value is not None:
                filled.values[row, column, name] = scaled(value, paper.metrics[name].factor)
    return filled


def _gap(cells: Mapping[Place, Sequence[Run]], tables: ClipTables) -> Estimate | None:
    """The lead of the best over the second mean PSNR among different runs."""
    distinct = {tuple(run.id for run in runs): runs for runs in cells.values() if runs}
    scored = [
        (value.mean, key) for key, runs in distinct.items() if (value := estimate(runs, "psnr", tables))
    ]
    if len(scored) < 2:
        return None
    best, second = (key for _, key in sorted(scored, reverse=True)[:2])
    return difference(distinct[best], distinct[second], "psnr", tables)


def _selections(table: PublishedTable, rows: Sequence[int]) -> dict[Place, Selection]:
    return {
        (row, index): {**table.base, **table.rows[row].select, **column.select}
        for row in rows
        for index, column in enumerate(table.columns)
        if column.select is not None
    }


def ranks(values: Mapping[Place, float], metric: Metric) -> dict[Place, Style]:
    """Bold for the best, underlined for the second of three or more; values equal as printed share their rank."""
    printed = {place: round(value, metric.decimals) for place, value in values.items()}
    order = sorted(set(printed.values()), reverse=metric.better == "higher")
    styles: dict[float, Style] = {}
    if len(printed) > 1 and len(order) > 1:
        styles[order[0]] = "bold"
        if len(printed) > 2:
            styles[order[1]] = "underline"
    return {place: styles.get(value, "plain") for place, value in printed.items()}


def number(value: Estimate, decimals: int, sign: bool = False) -> str:
    """``mean ± half-width``; the half-width is left away where there is none."""
    mean = f"{value.mean:{'+' if sign else ''}.{decimals}f}".replace("-", "−").replace("inf", "∞")
    return mean if math.isnan(value.half_width) else f"{mean} ± {value.half_width:.{decimals}f}"


def sheet(filled: Filled, paper: Paper) -> Sheet:
    """The table to typeset: published and ours side by side, one line a metric."""
    table = filled.table
    styles = _styles(filled, paper)
    names = table.columns[0].metrics if table.compare == "row" else [""]
    body: list[list[Text]] = []
    for index, row in enumerate(table.rows):
        for line, name in enumerate(names):
            labels = [Text(label if line == 0 else "") for label in row.labels]
            metric = [Text(_metric_label(paper.metrics[name]))] if name else []
            pairs = [
                _pair(filled, paper, styles, index, column, line) for column in range(len(table.columns))
            ]
            body.append([*labels, *metric, *(text for pair in pairs for text in pair)])
    label_heads = [*table.headers, *(["metric"] if names[0] else [])]
    return Sheet(
        name=f"table{table.number}",
        title=f"Table {table.number} of the {paper.short}.",
        groups=[*(("", 1) for _ in label_heads), *((column.label, 2) for column in table.columns)],
        headers=[*label_heads, *([paper.short, "ours"] * len(table.columns))],
        rows=body,
        labels=len(label_heads),
        notes=_notes(filled, paper),
        rules=list(range(0, len(body), len(names))) if len(names) > 1 else [],
    )


def _metric_label(metric: Metric) -> str:
    return metric.label if metric.unit.startswith("1") else f"{metric.label} ({metric.unit})"


def _pair(
    filled: Filled,
    paper: Paper,
    styles: Mapping[tuple[int, int, str], Style],
    row: int,
    column: int,
    line: int,
) -> tuple[Text, Text]:
    """The published and our text of a cell's ``line``-th metric."""
    name = filled.table.columns[column].metrics[line]
    decimals = paper.metrics[name].decimals
    published = Text(f"{filled.table.rows[row].values[column][line]:.{decimals}f}")
    value = filled.values.get((row, column, name))
    if value is not None:
        return published, Text(number(value, decimals), styles[row, column, name])
    return published, Text(NOT_AVAILABLE if filled.table.columns[column].select is None else NOT_RUN, "muted")


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
    notes = [
        f"{table.title} (Section {table.section}, p. {table.page} ff.)",
        *([table.note] if table.note else []),
    ]
    if not filled.settings:
        return [*notes, "Ours: not run."]
    by_setting: dict[Setting, list[str]] = {}
    for row, setting in sorted(filled.settings.items()):
        by_setting.setdefault(setting, []).append("/".join(table.rows[row].labels))
    if len(by_setting) == 1:
        notes.append(f"Ours: {next(iter(by_setting))}.")
    else:
        notes.append(
            "Ours: " + "; ".join(f"row {', '.join(rows)}: {key}" for key, rows in by_setting.items()) + "."
        )
    seeds = sorted({len(runs) for runs in filled.runs.values()})
    if seeds[-1] > 1:
        notes.append(f"Mean over {' to '.join(str(n) for n in sorted({seeds[0], seeds[-1]}))} seeds.")
    if any(paper.metrics[name].ours == "mssim_thesis" for _, _, name in filled.values):
        notes.append("SSIM after the thesis's definition (mssim_thesis).")
    if filled.gaps:
        leads = "; ".join(f"{name} {_interval(gap)}" for name, gap in filled.gaps.items())
        notes.append(f"Lead of our best over our second PSNR in dB, paired over clips: {leads}.")
    if filled.left_out:
        notes.append(f"{len(filled.left_out)} matching runs with other settings or repeated seeds left out.")
    return notes


def _interval(gap: Estimate) -> str:
    if math.isnan(gap.low):
        return f"{gap.mean:.2f} without interval"
    text = f"{gap.mean:.2f} ({gap.low:.2f} to {gap.high:.2f}".replace("-", "−")
    return text + (")" if gap.resolved else ", unresolved)")


def long_form(filled: Filled, paper: Paper) -> list[dict[str, object]]:
    """One row for each number of the table: published, ours, half-width and the runs behind it."""
    rows: list[dict[str, object]] = []
    for index, row in enumerate(filled.table.rows):
        for place, column in enumerate(filled.table.columns):
            runs = filled.runs.get((index, place), [])
            setting = filled.settings.get(index)
            for line, name in enumerate(column.metrics):
                metric, value = paper.metrics[name], filled.values.get((index, place, name))
                state = "run" if value else NOT_AVAILABLE if column.select is None else NOT_RUN
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
                        "state": state,
                        "setting": str(setting) if runs else "",
                        "runs": " ".join(run.id for run in runs),
                    }
                )
    return rows
