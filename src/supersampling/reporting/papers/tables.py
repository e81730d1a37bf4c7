"""A paper's table with our numbers in its cells: which runs, their values, and the best of each comparison."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from supersampling.reporting.pages.sheet import Style
from supersampling.reporting.papers.schema import Metric, Paper, PublishedTable, Selection
from supersampling.reporting.selection import choose_runs, pools_for
from supersampling.reporting.settings import Choice, Setting
from supersampling.runs.estimates import ClipTables, difference, estimate, logged, scaled
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run

NOT_RUN, NOT_AVAILABLE = "not run", "not available"
NOT_MEASURED, NOT_SCORED = "not measured", "not scored"
Place = tuple[int, int]


@dataclass(frozen=True)
class TableRuns:
    """The runs of a table's cells ``(row, column)``, each row's setting, and the runs that matched but were left out."""

    table: PublishedTable
    settings: dict[int, Setting]
    cells: dict[Place, list[Run]]
    left_out: list[Run]


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

    def state(self, row: int, column: int, metric: Metric) -> str:
        """Why a cell has no number of ours."""
        if self.table.rows[row].select is None or self.table.columns[column].select is None:
            return NOT_AVAILABLE
        if metric.ours is None:
            return NOT_MEASURED
        return NOT_SCORED if (row, column) in self.runs else NOT_RUN


def choose_table(table: PublishedTable, choice: Choice) -> TableRuns:
    """Find our runs for each cell. Cells that are compared (along a row or a column) share one setting."""
    found = TableRuns(table, {}, {}, [])
    for group in _groups(table):
        selections = _selections(table, group)
        pools = pools_for(choice, selections.values(), table.prefer or {})
        if not pools:
            continue
        setting, runs = pools[0]
        chosen = choose_runs(runs, selections)
        found.settings.update(dict.fromkeys(group, setting))
        found.cells.update({place: runs for place, runs in chosen.cells.items() if runs})
        found.left_out.extend(chosen.left_out)
    return found


def fill(chosen: TableRuns, paper: Paper, tables: ClipTables) -> Filled:
    """The chosen runs' values, in the table's unit."""
    table = chosen.table
    filled = Filled(table, chosen.settings, chosen.cells, {}, chosen.left_out, {})
    for (row, column), runs in chosen.cells.items():
        for name in table.columns[column].metrics:
            metric = paper.metrics[name]
            if metric.ours is None:
                continue
            of_run = table.source == "run"
            value = logged(runs, metric.ours) if of_run else estimate(runs, metric.ours, tables)
            if value is not None and not math.isnan(value.mean):
                filled.values[row, column, name] = scaled(value, metric.factor)
    if any(paper.metrics[name].ours == "psnr" for column in table.columns for name in column.metrics):
        for group in _groups(table):
            cells = [runs for (row, _), runs in chosen.cells.items() if row in group]
            gap = _gap(cells, tables)
            if gap is not None:
                filled.gaps["/".join(table.rows[group[0]].labels) if table.compare == "row" else "PSNR"] = gap
    return filled


def _groups(table: PublishedTable) -> list[list[int]]:
    """The rows that are compared with each other."""
    rows = range(len(table.rows))
    return [[row] for row in rows] if table.compare == "row" else [list(rows)]


def _gap(cells: Sequence[list[Run]], tables: ClipTables) -> Estimate | None:
    """The lead of the best over the second mean PSNR among different runs."""
    distinct = {tuple(run.id for run in runs): runs for runs in cells}
    scored = [(value.mean, key) for key, runs in distinct.items() if (value := estimate(runs, "psnr", tables))]
    if len(scored) < 2:
        return None
    best, second = (key for _, key in sorted(scored, reverse=True)[:2])
    return difference(distinct[best], distinct[second], "psnr", tables)


def _selections(table: PublishedTable, rows: Sequence[int]) -> dict[Place, Selection]:
    return {
        (row, index): {**table.base, **select, **column.select}
        for row in rows
        for index, column in enumerate(table.columns)
        if column.select is not None and (select := table.rows[row].select) is not None
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
