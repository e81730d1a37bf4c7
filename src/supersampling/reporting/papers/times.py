"""The numbers of a paper's cells that benchmarks measured: times of methods and of their parts, and sizes of modules.

Times are compared within one run of ``benchmark.py`` only, on one device and in one precision, and under one backend
unless the selections name it (docs/benchmark.md).
"""

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from supersampling.reporting.papers.schema import BENCHMARK, Metric, PublishedTable, Selection
from supersampling.reporting.selection import choose_runs
from supersampling.runs.measurements import Measurement

PART, SIZE, BACKEND, PRECISION = "part", "size", "backend", "precision"
RENDER = "render"  # in the names of the renderer's parts
EXACT = "float32"
Key = TypeVar("Key", bound=Hashable)
TableTimes = Mapping[tuple[int, int, str], "Measured"]


@dataclass(frozen=True)
class Measured:
    """A cell's number, in the benchmark's unit, the measurement that it is from, and the part that it is of.

    NaN if the method was measured, but has no such part.
    """

    value: float
    measurement: Measurement
    part: str


def table_times(
    table: PublishedTable, metrics: Mapping[str, Metric], measurements: Sequence[Measurement]
) -> TableTimes:
    """Return the measured cells ``(row, column, metric)`` of a table."""
    cells = {
        (row, column, name): (selection, quantity)
        for (row, column), selection in table.selections.items()
        for name in table.columns[column].metrics
        if (quantity := quantity_of(metrics[name].logged)) is not None
    }
    return choose_times(cells, measurements) if cells else {}


def quantity_of(logged: str | None) -> str | None:
    """Return what a benchmark measured for a metric, None if the metric is not a benchmark's."""
    return logged.removeprefix(BENCHMARK) if logged is not None and logged.startswith(BENCHMARK) else None


def describe(cells: Iterable[Measured]) -> str:
    """Return how and where cells were measured: ``eager and native, float32, cpu, 2 threads; Linux x86_64 ...``.

    Empty without cells. They are of one benchmark.
    """
    items = list(cells)
    backends = " and ".join(sorted({item.measurement.run.params[BACKEND] for item in items}))
    places = sorted({item.measurement.where for item in items})
    renderers = sorted({item.measurement.renderer for item in items if RENDER in item.part})
    return "; ".join([f"{backends}, {place}" for place in places] + [f"rendering by {name}" for name in renderers])


def choose_times(
    cells: Mapping[Key, tuple[Selection, str]], measurements: Sequence[Measurement]
) -> dict[Key, Measured]:
    """Return the numbers of the cells that one series of measurements has.

    A series is of one benchmark. Of several the one that fills most cells counts, then the newest, then the faster.

    Args:
        cells: the selection and the quantity of each cell. A selection names the target's ``size``, may name the
            ``part``, and has parameters of the method otherwise.
    """
    names = {name for selection, _ in cells.values() for name in selection}
    best: dict[Key, Measured] = {}
    for series in _series(measurements, names):
        candidate = _fill(cells, series)
        if _rank(candidate) > _rank(best):
            best = candidate
    return best


def _series(measurements: Sequence[Measurement], names: set[str]) -> list[list[Measurement]]:
    series: dict[tuple[Any, ...], list[Measurement]] = {}
    for item in measurements:
        params = item.run.params
        if PRECISION not in names and params[PRECISION] != EXACT:
            continue
        backend = "" if BACKEND in names else params[BACKEND]
        key = (item.benchmark.id, params[PRECISION], params["device"], params["threads"], backend)
        series.setdefault(key, []).append(item)
    return list(series.values())


def _fill(cells: Mapping[Key, tuple[Selection, str]], series: Sequence[Measurement]) -> dict[Key, Measured]:
    """Return the cells of one configuration of each model."""
    selections = {
        key: {name: value for name, value in selection.items() if name != PART} for key, (selection, _) in cells.items()
    }
    by_id = {item.run.id: item for item in series}
    filled: dict[Key, Measured] = {}
    for key, runs in choose_runs([item.run for item in series], selections).cells.items():
        for run in runs:
            selection, quantity = cells[key]
            part = selection.get(PART, "")
            value = by_id[run.id].value(quantity, part)
            filled[key] = Measured(math.nan if value is None else value, by_id[run.id], part)
    return filled


def _rank(filled: Mapping[Any, Measured]) -> tuple[int, int, float]:
    ended = max((item.measurement.benchmark.ended for item in filled.values()), default=0)
    values = [item.value for item in filled.values() if not math.isnan(item.value)]
    return len(values), ended, -sum(values)
