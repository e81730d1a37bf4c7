"""A paper's table with our numbers in its cells: the runs, their values, and the best of each comparison."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from supersampling.reporting.pages.sheet import Style
from supersampling.reporting.papers.schema import Metric, Paper, PublishedTable, Selection
from supersampling.reporting.papers.times import TableTimes, describe, quantity_of
from supersampling.reporting.selection import choose_runs, pools_for
from supersampling.reporting.settings import Choice, Setting
from supersampling.runs.estimates import ClipTables, difference, estimate, logged, scaled
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run

NOT_RUN, NOT_AVAILABLE = "not run", "not available"
NOT_MEASURED, NOT_SCORED = "not measured", "not scored"
NO_PART = "no such part"
Place = tuple[int, int]


@dataclass(frozen=True)
class TableRuns:
    """The runs of a table's cells ``(row, column)``, each row's setting, and the runs that match but are left out.

    ``times`` are the cells that benchmarks fill.
    """

    table: PublishedTable
    settings: dict[int, Setting]
    cells: dict[Place, list[Run]]
    left_out: list[Run]
    times: TableTimes = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Filled:
    """A published table's cells ``(row, column)`` that our runs fill, and each row's setting.

    Attributes:
        left_out: runs that match a cell but differ in other settings.
        gaps: how far the best PSNR leads the second, paired over clips, by the name of a comparison.
        measured: how and where benchmarks measured their cells; empty if they measured none.
    """

    table: PublishedTable
    settings: dict[int, Setting]
    runs: dict[Place, list[Run]]
    values: dict[tuple[int, int, str], Estimate]
    left_out: list[Run]
    gaps: dict[str, Estimate]
    measured: str = ""

    def state(self, row: int, column: int, metric: Metric) -> str:
        """Return why a cell has no number of ours."""
        if self.table.rows[row].select is None or self.table.columns[column].select is None:
            return NOT_AVAILABLE
        if metric.logged is None:
            return NOT_MEASURED
        if (row, column) not in self.runs:
            return NOT_RUN
        return NO_PART if quantity_of(metric.logged) is not None else NOT_SCORED


def choose_table(table: PublishedTable, choice: Choice) -> TableRuns:
    """Return our runs for each cell; cells that are compared (along a row or a column) share one setting."""
    selected = TableRuns(table, {}, {}, [])
    for group in _groups(table):
        selections = _selections(table, group)
        pools = pools_for(choice, selections.values(), table.prefer or {})
        if not pools:
            continue
        setting, runs = pools[0]
        matches = choose_runs(runs, selections)
        selected.settings.update(dict.fromkeys(group, setting))
        selected.cells.update({place: members for place, members in matches.cells.items() if members})
        selected.left_out.extend(matches.left_out)
    return selected


def fill(selected: TableRuns, paper: Paper, tables: ClipTables) -> Filled:
    """Return the table with the selected runs' values, in the table's unit."""
    table = selected.table
    values: dict[tuple[int, int, str], Estimate] = {}
    for (row, column), runs in selected.cells.items():
        for name in table.columns[column].metrics:
            metric = paper.metrics[name]
            if metric.logged is None:
                continue
            value = logged(runs, metric.logged) if table.source == "run" else estimate(runs, metric.logged, tables)
            if value is not None and not math.isnan(value.mean):
                values[row, column, name] = scaled(value, metric.factor)
    cells = dict(selected.cells)
    for (row, column, name), item in selected.times.items():
        cells[row, column] = [item.measurement.benchmark]
        if not math.isnan(item.value):
            exact = Estimate(item.value, math.nan, math.nan, 0)
            values[row, column, name] = scaled(exact, paper.metrics[name].factor)
    gaps: dict[str, Estimate] = {}
    if any(paper.metrics[name].logged == "psnr" for column in table.columns for name in column.metrics):
        for group in _groups(table):
            gap = _gap([runs for (row, _), runs in selected.cells.items() if row in group], tables)
            if gap is not None:
                gaps["/".join(table.rows[group[0]].labels) if table.compare == "row" else "PSNR"] = gap
    return Filled(
        table=table,
        settings=selected.settings,
        runs=cells,
        values=values,
        left_out=selected.left_out,
        gaps=gaps,
        measured=describe(selected.times.values()),
    )


def _groups(table: PublishedTable) -> list[list[int]]:
    """Return the rows that are compared with each other."""
    rows = range(len(table.rows))
    return [[row] for row in rows] if table.compare == "row" else [list(rows)]


def _gap(cells: Sequence[list[Run]], tables: ClipTables) -> Estimate | None:
    """Return the lead of the best over the second mean PSNR among different runs; None for fewer than two."""
    distinct = {tuple(run.id for run in runs): runs for runs in cells}
    scored = [(value.mean, key) for key, runs in distinct.items() if (value := estimate(runs, "psnr", tables))]
    if len(scored) < 2:
        return None
    best, second = (key for _, key in sorted(scored, reverse=True)[:2])
    return difference(distinct[best], distinct[second], "psnr", tables)


def _selections(table: PublishedTable, rows: Sequence[int]) -> dict[Place, Selection]:
    return {place: selection for place, selection in table.selections.items() if place[0] in rows}


def ranks(values: Mapping[Place, float], metric: Metric) -> dict[Place, Style]:
    """Return bold for the best, underlined for the second of three or more; values that print equally share a rank."""
    printed = {place: round(value, metric.decimals) for place, value in values.items()}
    order = sorted(set(printed.values()), reverse=metric.better == "higher")
    styles: dict[float, Style] = {}
    if len(printed) > 1 and len(order) > 1:
        styles[order[0]] = "bold"
        if len(printed) > 2:
            styles[order[1]] = "underline"
    return {place: styles.get(value, "plain") for place, value in printed.items()}
