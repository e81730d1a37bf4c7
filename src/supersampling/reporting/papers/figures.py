"""The runs of a paper's figures: for each series its points."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from supersampling.reporting.papers.schema import PublishedFigure
from supersampling.reporting.selection import choose_runs, matches, pools_for
from supersampling.reporting.settings import Choice, Setting
from supersampling.runs.store import Run

FRAME = "frame"


@dataclass(frozen=True)
class FigureRuns:
    """A figure's runs: for each series its points by ``x`` (one with an empty name if ``x`` is no run parameter)."""

    figure: PublishedFigure
    setting: Setting | None
    points: dict[str, dict[str, list[Run]]]

    @property
    def missing(self) -> list[str]:
        """The labels of the series without any run."""
        return [label for label, points in self.points.items() if not any(points.values())]

    @property
    def over_frames(self) -> bool:
        """Whether frames are its values, not clips."""
        return self.figure.x == FRAME

    @property
    def runs(self) -> list[Run]:
        return [run for points in self.points.values() for runs in points.values() for run in runs]


def choose_figure(figure: PublishedFigure, choice: Choice) -> FigureRuns:
    """Return the runs of one setting that agree in all that the figure does not name.

    Of several settings the first that has most series.
    """
    selections = {series.label: {**figure.base, **series.select} for series in figure.series}
    best = FigureRuns(figure, None, {label: {} for label in selections})
    for setting, pool in pools_for(choice, selections.values(), {}):
        keys = {
            (label, x): {**selection, **({figure.x: x} if x and figure.x else {})}
            for label, selection in selections.items()
            for x in _values(figure, [run for run in pool if matches(run, selection)])
        }
        cells = choose_runs(pool, keys).cells
        points: dict[str, dict[str, list[Run]]] = {label: {} for label in selections}
        for label, x in keys:
            if cells[label, x]:
                points[label][x] = cells[label, x]
        candidate = FigureRuns(figure, setting, points)
        if len(candidate.missing) < len(best.missing):
            best = candidate
        if not best.missing:
            break
    return best


def _values(figure: PublishedFigure, runs: Sequence[Run]) -> list[str]:
    """Return the values of ``x`` that these runs have; an empty name if it is no run parameter."""
    values = {run.params[figure.x] for run in runs if figure.x is not None and figure.x in run.params}
    return sorted(values, key=numbers_first) if values else [""]


def numbers_first(value: str) -> tuple[float, str]:
    """Return a key that sorts numbers by value, and words behind them."""
    try:
        return float(value), ""
    except ValueError:
        return math.inf, value
