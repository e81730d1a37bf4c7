"""The papers' figures from our runs, as vector graphics: boxes, curves, bars, quality against cost, training."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from supersampling.reporting.figures.style import STYLE, WIDTH, colour, dash, mark, save, scatter
from supersampling.reporting.figures.training import LABELS, History, training_curves
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
METRICS = {**LABELS, "pixel_distance": "distance to the pixel centre (target pixels)"}
HEIGHT = 2.7  # of a panel, in inches


@dataclass(frozen=True)
class Scores:
    """The material of figures: the tables of clips and frames by run id, and what a run logged by step."""

    clips: ClipTables
    frames: ClipTables
    history: History


def section(report: Report) -> Section | None:
    """Return a paper's figures; None for the overview, and for a paper without any."""
    if report.subject is None or not report.subject.figures:
        return None
    paper = report.subject.paper
    return Section(title="Figures", figures=[_figure(figure, paper, report) for figure in report.subject.figures])


def _figure(runs: FigureRuns, paper: Paper, report: Report) -> parts.Figure:
    figure, material = runs.figure, report.material
    labels = [_label(metric, paper) for metric in figure.metrics]
    path = Path(f"{report.stem}_figure{stem_of(figure.number)}.pdf")
    scores = Scores(material.clips, material.frames, material.store.history)
    drawn = draw(runs, scores, labels, path)
    notes = [f"After {name_of(figure.number, 'Figure')} {paper.of}: {figure.caption}.", figure.note]
    if runs.setting is not None:
        notes.append(f"Ours: {runs.setting}.")
    if runs.missing:
        notes.append(f"Not run: {', '.join(runs.missing)}" + (f" (sweeps={figure.sweep})." if figure.sweep else "."))
    if runs.runs and (absent := [metric for metric in figure.metrics if metric not in drawn]):
        notes.append(f"Not drawn: the runs did not log {', '.join(absent)}.")
    return parts.Figure(path.name if drawn else "", " ".join(note for note in notes if note))


def _label(name: str, paper: Paper) -> str:
    metric = next((m for m in paper.metrics.values() if m.logged == name), None)
    return metric_label(metric) if metric else METRICS.get(name, name)


def draw(runs: FigureRuns, scores: Scores, labels: Sequence[str], path: Path) -> list[str]:
    """Write the figure as PDF, with a panel for each metric that runs logged, and return these metrics.

    Without any nothing is written. ``labels`` name the metrics.
    """
    kinds: dict[str, Callable[[Axes, str], int]] = {
        "box": lambda ax, metric: _boxes(ax, _box_values(runs, metric, scores)),
        "bars": lambda ax, metric: _bars(ax, runs, metric, scores.clips),
        "curve": lambda ax, metric: (
            _frame_curve(ax, runs, metric, scores.frames)
            if runs.over_frames
            else _curve(ax, runs, metric, scores.clips)
        ),
        "front": lambda ax, metric: _front(ax, runs, metric, scores.clips),
        "training": lambda ax, metric: training_curves(ax, _series(runs), metric, scores.history),
    }
    metrics = runs.figure.metrics
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        axes = list(figure.subplots(1, len(metrics), squeeze=False)[0])
        drawn = [kinds[runs.figure.kind](ax, metric) for ax, metric in zip(axes, metrics)]
        for ax, label, count in zip(axes, labels, drawn):
            ax.set_ylabel(label)
            if not count:
                ax.remove()
        if not any(drawn):
            return []
        handles, names = next(ax for ax, count in zip(axes, drawn) if count).get_legend_handles_labels()
        if runs.figure.kind in ("curve", "training") and len(runs.points) > 1:
            figure.legend(handles, names, loc="outside upper center", ncols=4)
        save(figure, path)
    return [metric for metric, count in zip(metrics, drawn) if count]


def _series(runs: FigureRuns) -> dict[str, list[Run]]:
    """Return each series' runs, for figures with a single point per series."""
    return {label: next(iter(points.values())) for label, points in runs.points.items() if points}


def _box_values(runs: FigureRuns, metric: str, scores: Scores) -> dict[str, np.ndarray]:
    """Return the finite values of each box, means over seeds: of clips, or of frames if the figure counts frames.

    A single series of frames has a box for each scene, as in the figure of Xiao et al. (2020, figure 11).
    """
    values: dict[str, np.ndarray] = {}
    for label, members in _series(runs).items():
        if not runs.over_frames:
            table = clip_scores(members, metric, scores.clips)
            if table is not None:
                values[label] = table.mean(axis=1).to_numpy()
        elif (frames := _frame_means(members, metric, scores.frames, ["scene", "clip", "frame"])) is not None:
            by_scene = {str(scene): part.to_numpy() for scene, part in frames.groupby(level="scene")}
            values |= by_scene if len(runs.points) == 1 else {label: frames.to_numpy()}
    finite = {label: numbers[np.isfinite(numbers)] for label, numbers in values.items()}
    return {label: numbers for label, numbers in finite.items() if len(numbers)}


def _frame_means(members: Sequence[Run], metric: str, frames: ClipTables, by: list[str]) -> pd.Series | None:
    """Return the metric's mean over seeds (and all that ``by`` does not name); None if no run logged it."""
    tables = [frames[run.id] for run in members if run.id in frames and metric in frames[run.id]]
    if not tables:
        return None
    rows = pd.concat([table[["scene", "clip", "frame", metric]] for table in tables])
    return rows.replace([np.inf, -np.inf], np.nan).groupby(by)[metric].mean().dropna()


def _boxes(ax: Axes, values: dict[str, np.ndarray]) -> int:
    """Draw boxes of quartiles and median; the whiskers reach at most 1.5 times the distance of the quartiles."""
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


def _bars(ax: Axes, runs: FigureRuns, metric: str, clips: ClipTables) -> int:
    values = {label: value for label, members in _series(runs).items() if (value := _value(members, metric, clips))}
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
    # What fits a page's width; panels beside each other have less.
    width = ax.get_position().width
    if sum(map(len, labels)) > 110 * width:
        ax.set_xticks(places, labels, rotation=30, ha="right")
    else:
        ax.set_xticks(places, labels)


def _curve(ax: Axes, runs: FigureRuns, metric: str, clips: ClipTables) -> int:
    """Draw the metric over the values of a run parameter, with intervals; words are placed at even distances."""
    names = sorted({x for points in runs.points.values() for x in points}, key=numbers_first)
    numeric = all(math.isfinite(numbers_first(x)[0]) for x in names)
    places = {x: numbers_first(x)[0] if numeric else float(i) for i, x in enumerate(names)}
    drawn = 0
    for index, (label, points) in enumerate(runs.points.items()):
        values = {places[x]: value for x, members in points.items() if (value := _value(members, metric, clips))}
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


def _frame_curve(ax: Axes, runs: FigureRuns, metric: str, frames: ClipTables) -> int:
    """Draw the metric over a clip's frames, the mean over clips and seeds."""
    drawn = 0
    for index, (label, members) in enumerate(_series(runs).items()):
        means = _frame_means(members, metric, frames, ["frame"])
        if means is not None:
            ax.plot(means.index.to_numpy(dtype=float), means.to_numpy(), dash(index), color=colour(index), label=label)
            drawn += 1
    ax.set_xlabel(AXES[FRAME])
    return drawn


def _front(ax: Axes, runs: FigureRuns, metric: str, clips: ClipTables) -> int:
    """Draw the metric against a cost that the runs logged, one point per series; a series without cost is left out."""
    points = []
    for label, members in _series(runs).items():
        cost, value = logged(members, runs.figure.x or ""), _value(members, metric, clips)
        if cost is not None and cost.mean > 0 and value is not None:
            points.append((label, cost.mean, value))
    scatter(ax, points)
    ax.set_xlabel(_axis(runs))
    return len(points)


def _axis(runs: FigureRuns) -> str:
    return AXES.get(runs.figure.x or "", runs.figure.x or "")


def _value(members: Sequence[Run], metric: str, clips: ClipTables) -> Estimate | None:
    value = estimate(members, metric, clips) or logged(members, metric)
    return value if value is not None and math.isfinite(value.mean) else None


def _error(value: Estimate) -> float | None:
    return None if math.isnan(value.half_width) else value.half_width
