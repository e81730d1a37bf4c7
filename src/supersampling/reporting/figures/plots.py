"""The papers' figures from our runs, as vector graphics: boxes over clips, curves, bars, quality against cost."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from supersampling.reporting.figures.figures import COLOURS, DASHES, MARKS, STYLE, WIDTH, save, scatter
from supersampling.reporting.papers.schema import PublishedFigure
from supersampling.reporting.selection import choose_runs, matches, pools_for
from supersampling.reporting.settings import Choice, Setting
from supersampling.runs.estimates import ClipTables, clip_scores, estimate, logged
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run

FRAME = "frame"
AXES = {
    FRAME: "frame of a clip", "model/parameters": "parameters", "model/gmac": "GMAC per frame",
    "train/minutes": "minutes of training",
}  # fmt: skip


@dataclass(frozen=True)
class FigureRuns:
    """A figure's runs: for each series its points by ``x`` (one without a name where ``x`` is no run parameter)."""

    figure: PublishedFigure
    setting: Setting | None
    points: dict[str, dict[str, list[Run]]]

    @property
    def missing(self) -> list[str]:
        return [label for label, points in self.points.items() if not any(points.values())]

    @property
    def over_frames(self) -> bool:
        return self.figure.x == FRAME


def choose_figure(figure: PublishedFigure, choice: Choice) -> FigureRuns:
    """The runs of one setting that agree in all that the figure does not name; of the settings the first with most."""
    selections = {series.label: {**figure.base, **series.select} for series in figure.series}
    best = FigureRuns(figure, None, {label: {} for label in selections})
    for setting, pool in pools_for(choice, selections.values(), {}):
        keys = {
            (label, x): {**selection, **({figure.x: x} if x and figure.x else {})}
            for label, selection in selections.items()
            for x in _values(figure, [run for run in pool if matches(run, selection)])
        }
        cells = choose_runs(pool, keys).cells
        points = {
            label: {x: cells[label, x] for one, x in keys if one == label and cells[label, x]} for label in selections
        }
        found = FigureRuns(figure, setting, points)
        if len(found.missing) < len(best.missing):
            best = found
        if not best.missing:
            break
    return best


def _values(figure: PublishedFigure, runs: Sequence[Run]) -> list[str]:
    """The values of ``x`` that these runs have; one without a name where it is no run parameter."""
    found = {run.params[figure.x] for run in runs if figure.x is not None and figure.x in run.params}
    return sorted(found, key=_order) if found else [""]


def _order(value: str) -> tuple[float, str]:
    try:
        return float(value), ""
    except ValueError:
        return math.inf, value


def draw(chosen: FigureRuns, clips: ClipTables, frames: ClipTables, label: str, path: Path) -> bool:
    """Write the figure as PDF; false where there is nothing to draw. ``label`` names the metric."""
    draws: dict[str, Callable[[Axes], int]] = {
        "box": lambda ax: _boxes(ax, chosen, clips),
        "bars": lambda ax: _bars(ax, chosen, clips),
        "curve": lambda ax: _frame_curve(ax, chosen, frames) if chosen.over_frames else _curve(ax, chosen, clips),
        "front": lambda ax: _front(ax, chosen, clips),
    }
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
        ax = figure.subplots()
        if not draws[chosen.figure.kind](ax):
            return False
        ax.set_ylabel(label)
        if chosen.figure.kind == "curve" and len(ax.get_legend_handles_labels()[1]) > 1:
            figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=4)
        save(figure, path)
    return True


def _runs(chosen: FigureRuns) -> dict[str, list[Run]]:
    """Each series' runs where it has a single point."""
    return {label: next(iter(points.values())) for label, points in chosen.points.items() if points}


def _boxes(ax: Axes, chosen: FigureRuns, clips: ClipTables) -> int:
    """A box a series over its clips' values (means over seeds): quartiles, median, whiskers to 1.5 of their distance."""
    found = {}
    for label, runs in _runs(chosen).items():
        scores = clip_scores(runs, chosen.figure.metric, clips)
        if scores is not None and len(scores):
            values = scores.mean(axis=1).to_numpy()
            found[label] = values[np.isfinite(values)]
    boxes = ax.boxplot(
        list(found.values()), widths=0.5, patch_artist=True, medianprops={"color": "black"},
        flierprops={"marker": ".", "markersize": 3},
    )  # fmt: skip
    for index, box in enumerate(boxes["boxes"]):
        box.set_facecolor(COLOURS[index % len(COLOURS)] + "80")
    _ticks(ax, list(found), start=1)
    room = max(0.5, (4 - len(found)) / 2)  # one box alone would be as wide as the page
    ax.set_xlim(1 - room, len(found) + room)
    return len(found)


def _bars(ax: Axes, chosen: FigureRuns, clips: ClipTables) -> int:
    found = {label: value for label, runs in _runs(chosen).items() if (value := _value(runs, chosen, clips))}
    for index, value in enumerate(found.values()):
        ax.bar(index, value.mean, 0.6, yerr=_error(value), capsize=2, color=COLOURS[index % len(COLOURS)])
    _ticks(ax, list(found), start=0)
    lows = [value.mean if math.isnan(value.low) else value.low for value in found.values()]
    highs = [value.mean if math.isnan(value.high) else value.high for value in found.values()]
    if found and min(lows) > 0:  # Bars of PSNR from 0 all look alike.
        ax.set_ylim(max(0.0, min(lows) - (max(highs) - min(lows))), None)
    return len(found)


def _ticks(ax: Axes, labels: list[str], start: int) -> None:
    places = range(start, start + len(labels))
    if sum(map(len, labels)) > 90:
        ax.set_xticks(places, labels, rotation=30, ha="right")
    else:
        ax.set_xticks(places, labels)


def _curve(ax: Axes, chosen: FigureRuns, clips: ClipTables) -> int:
    """The metric over the values of a run parameter, with intervals; values that are no numbers are set apart evenly."""
    names = sorted({x for points in chosen.points.values() for x in points}, key=_order)
    numeric = all(math.isfinite(_order(x)[0]) for x in names)
    at = {x: _order(x)[0] if numeric else float(i) for i, x in enumerate(names)}
    drawn = 0
    for index, (label, points) in enumerate(chosen.points.items()):
        values = {at[x]: value for x, runs in points.items() if (value := _value(runs, chosen, clips))}
        if values:
            errors = [[_error(value) or 0.0 for value in values.values()]] * 2
            ax.errorbar(
                list(values), [value.mean for value in values.values()], errors, marker=MARKS[index % len(MARKS)],
                markersize=3, capsize=2, color=COLOURS[index % len(COLOURS)], label=label,
            )  # fmt: skip
            drawn += 1
    ax.set_xticks(list(at.values()), names)
    ax.set_xlabel(AXES.get(chosen.figure.x or "", chosen.figure.x or ""))
    return drawn


def _frame_curve(ax: Axes, chosen: FigureRuns, frames: ClipTables) -> int:
    """The metric over a clip's frames, mean over clips and seeds."""
    drawn = 0
    for index, (label, runs) in enumerate(_runs(chosen).items()):
        tables = [frames[run.id] for run in runs if run.id in frames and chosen.figure.metric in frames[run.id]]
        if not tables:
            continue
        every = pd.concat([table[["frame", chosen.figure.metric]] for table in tables])
        means = every.replace([np.inf, -np.inf], np.nan).groupby("frame")[chosen.figure.metric].mean().dropna()
        style = DASHES[index // len(COLOURS) % len(DASHES)]
        x = means.index.to_numpy(dtype=float)
        ax.plot(x, means.to_numpy(), style, color=COLOURS[index % len(COLOURS)], label=label)
        drawn += 1
    ax.set_xlabel(AXES[FRAME])
    return drawn


def _front(ax: Axes, chosen: FigureRuns, clips: ClipTables) -> int:
    """The metric against a cost that the runs logged, a point a series; a series without cost is left out."""
    points = []
    for label, runs in _runs(chosen).items():
        cost, value = logged(runs, chosen.figure.x or ""), _value(runs, chosen, clips)
        if cost is not None and cost.mean > 0 and value is not None:
            points.append((label, cost.mean, value))
    scatter(ax, points)
    ax.set_xlabel(AXES.get(chosen.figure.x or "", chosen.figure.x or ""))
    return len(points)


def _value(runs: Sequence[Run], chosen: FigureRuns, clips: ClipTables) -> Estimate | None:
    value = estimate(runs, chosen.figure.metric, clips) or logged(runs, chosen.figure.metric)
    return value if value is not None and math.isfinite(value.mean) else None


def _error(value: Estimate) -> float | None:
    return None if math.isnan(value.half_width) else value.half_width
