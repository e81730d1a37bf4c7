"""The papers' figures from our runs, as vector graphics: boxes over clips, curves, bars, quality against cost."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from supersampling.reporting.figures.style import STYLE, WIDTH, colour, dash, mark, save, scatter
from supersampling.reporting.pages import section as parts
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.tables import metric_label
from supersampling.reporting.papers.figures import FRAME, FigureRuns, numbers_first
from supersampling.reporting.papers.published import name_of, stem_of
from supersampling.reporting.papers.schema import Paper
from supersampling.runs.estimates import ClipTables, clip_scores, estimate, logged
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run

AXES = {
    FRAME: "frame of a clip",
    "model/parameters": "parameters",
    "model/gmac": "GMAC per frame",
    "train/minutes": "minutes of training",
}


def section(report: Report) -> Section | None:
    """Return a paper's figures; None for the overview, and for a paper without any."""
    if report.subject is None or not report.subject.figures:
        return None
    paper = report.subject.paper
    return Section(title="Figures", figures=[_figure(figure, paper, report) for figure in report.subject.figures])


def _figure(runs: FigureRuns, paper: Paper, report: Report) -> parts.Figure:
    figure = runs.figure
    metric = next((m for m in paper.metrics.values() if m.logged == figure.metric), None)
    label = metric_label(metric) if metric else figure.metric
    path = Path(f"{report.stem}_figure{stem_of(figure.number)}.pdf")
    drawn = draw(runs, report.material.clips, report.material.frames, label, path)
    notes = [f"After {name_of(figure.number, 'Figure')} {paper.of}: {figure.caption}.", figure.note]
    if runs.setting is not None:
        notes.append(f"Ours: {runs.setting}.")
    if runs.missing:
        notes.append(f"Not run: {', '.join(runs.missing)}" + (f" (sweeps={figure.sweep})." if figure.sweep else "."))
    return parts.Figure(path.name if drawn else "", " ".join(note for note in notes if note))


def draw(runs: FigureRuns, clips: ClipTables, frames: ClipTables, label: str, path: Path) -> bool:
    """Write the figure as PDF; return False if there is nothing to draw. ``label`` names the metric."""
    kinds: dict[str, Callable[[Axes], int]] = {
        "box": lambda ax: _boxes(ax, runs, clips),
        "bars": lambda ax: _bars(ax, runs, clips),
        "curve": lambda ax: _frame_curve(ax, runs, frames) if runs.over_frames else _curve(ax, runs, clips),
        "front": lambda ax: _front(ax, runs, clips),
    }
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
        ax = figure.subplots()
        if not kinds[runs.figure.kind](ax):
            return False
        ax.set_ylabel(label)
        if runs.figure.kind == "curve" and len(ax.get_legend_handles_labels()[1]) > 1:
            figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=4)
        save(figure, path)
    return True


def _series(runs: FigureRuns) -> dict[str, list[Run]]:
    """Return each series' runs, for figures with a single point per series."""
    return {label: next(iter(points.values())) for label, points in runs.points.items() if points}


def _boxes(ax: Axes, runs: FigureRuns, clips: ClipTables) -> int:
    """Draw one box per series over its clips' values (means over seeds).

    A box shows quartiles and median; the whiskers reach at most 1.5 times the distance of the quartiles.
    """
    values = {}
    for label, members in _series(runs).items():
        scores = clip_scores(members, runs.figure.metric, clips)
        if scores is not None and len(scores):
            means = scores.mean(axis=1).to_numpy()
            values[label] = means[np.isfinite(means)]
    boxes = ax.boxplot(
        list(values.values()),
        widths=0.5,
        patch_artist=True,
        medianprops={"color": "black"},
        flierprops={"marker": ".", "markersize": 3},
    )
    for index, box in enumerate(boxes["boxes"]):
        box.set_facecolor(colour(index) + "80")
    _label_ticks(ax, list(values), start=1)
    # Without it a single box would be as wide as the page.
    room = max(0.5, (4 - len(values)) / 2)
    ax.set_xlim(1 - room, len(values) + room)
    return len(values)


def _bars(ax: Axes, runs: FigureRuns, clips: ClipTables) -> int:
    values = {label: value for label, members in _series(runs).items() if (value := _value(members, runs, clips))}
    for index, value in enumerate(values.values()):
        ax.bar(index, value.mean, 0.6, yerr=_error(value), capsize=2, color=colour(index))
    _label_ticks(ax, list(values), start=0)
    lows = [value.mean if math.isnan(value.low) else value.low for value in values.values()]
    highs = [value.mean if math.isnan(value.high) else value.high for value in values.values()]
    # Bars of PSNR from 0 all look alike.
    if values and min(lows) > 0:
        ax.set_ylim(max(0.0, min(lows) - (max(highs) - min(lows))), None)
    return len(values)


def _label_ticks(ax: Axes, labels: list[str], start: int) -> None:
    places = range(start, start + len(labels))
    if sum(map(len, labels)) > 90:
        ax.set_xticks(places, labels, rotation=30, ha="right")
    else:
        ax.set_xticks(places, labels)


def _curve(ax: Axes, runs: FigureRuns, clips: ClipTables) -> int:
    """Draw the metric over the values of a run parameter, with intervals; words are placed at even distances."""
    names = sorted({x for points in runs.points.values() for x in points}, key=numbers_first)
    numeric = all(math.isfinite(numbers_first(x)[0]) for x in names)
    places = {x: numbers_first(x)[0] if numeric else float(i) for i, x in enumerate(names)}
    drawn = 0
    for index, (label, points) in enumerate(runs.points.items()):
        values = {places[x]: value for x, members in points.items() if (value := _value(members, runs, clips))}
        if values:
            ax.errorbar(
                list(values),
                [value.mean for value in values.values()],
                [[_error(value) or 0.0 for value in values.values()]] * 2,
                marker=mark(index),
                markersize=3,
                capsize=2,
                color=colour(index),
                label=label,
            )
            drawn += 1
    ax.set_xticks(list(places.values()), names)
    ax.set_xlabel(_axis(runs))
    return drawn


def _frame_curve(ax: Axes, runs: FigureRuns, frames: ClipTables) -> int:
    """Draw the metric over a clip's frames, the mean over clips and seeds."""
    metric = runs.figure.metric
    drawn = 0
    for index, (label, members) in enumerate(_series(runs).items()):
        tables = [frames[run.id] for run in members if run.id in frames and metric in frames[run.id]]
        if not tables:
            continue
        rows = pd.concat([table[["frame", metric]] for table in tables])
        means = rows.replace([np.inf, -np.inf], np.nan).groupby("frame")[metric].mean().dropna()
        ax.plot(means.index.to_numpy(dtype=float), means.to_numpy(), dash(index), color=colour(index), label=label)
        drawn += 1
    ax.set_xlabel(AXES[FRAME])
    return drawn


def _front(ax: Axes, runs: FigureRuns, clips: ClipTables) -> int:
    """Draw the metric against a cost that the runs logged, one point per series; a series without cost is left out."""
    points = []
    for label, members in _series(runs).items():
        cost, value = logged(members, runs.figure.x or ""), _value(members, runs, clips)
        if cost is not None and cost.mean > 0 and value is not None:
            points.append((label, cost.mean, value))
    scatter(ax, points)
    ax.set_xlabel(_axis(runs))
    return len(points)


def _axis(runs: FigureRuns) -> str:
    return AXES.get(runs.figure.x or "", runs.figure.x or "")


def _value(members: Sequence[Run], runs: FigureRuns, clips: ClipTables) -> Estimate | None:
    value = estimate(members, runs.figure.metric, clips) or logged(members, runs.figure.metric)
    return value if value is not None and math.isfinite(value.mean) else None


def _error(value: Estimate) -> float | None:
    return None if math.isnan(value.half_width) else value.half_width
