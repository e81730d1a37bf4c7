"""Vector figures of a report. Colours are Okabe and Ito's (grey for their yellow), for colour-blind readers."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure

from supersampling.reporting.pages.overview import Method, short_labels
from supersampling.runs.estimates import ClipTables, estimate
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Store

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000", "#7F7F7F")
MARKS = "osD^vP*X"
DASHES = ("-", "--", "-.", ":")
CLIPS_A_ROW = 10
STYLE: dict[Any, Any] = {
    "font.size": 7, "font.family": "DejaVu Sans", "axes.linewidth": 0.5, "axes.spines.top": False,
    "axes.spines.right": False, "xtick.major.width": 0.5, "ytick.major.width": 0.5, "lines.linewidth": 0.9,
    "legend.frameon": False, "pdf.fonttype": 42,
}  # fmt: skip
WIDTH = 6.7


def frames_figure(found: Sequence[Method], frames: ClipTables, path: Path) -> int:
    """PSNR of every test frame, clip after clip (the thesis's figure 8); returns how many methods have frames."""
    means = [(m.label, s) for m in found if (s := _frame_means(m, frames)) is not None]
    series = dict(zip(short_labels([label for label, _ in means]), (s for _, s in means)))
    if not series:
        return 0
    clips = sorted({key[:2] for values in series.values() for key in values.index})
    rows = -(-len(clips) // CLIPS_A_ROW)
    each = -(-len(clips) // rows)
    lines = [clips[i : i + each] for i in range(0, len(clips), each)]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.35 + 1.55 * len(lines)), layout="constrained")
        axes = figure.subplots(len(lines), 1, squeeze=False, sharey=True)[:, 0]
        for ax, chosen in zip(axes, lines):
            _frame_line(ax, chosen, series)
        axes[-1].set_xlabel("frame, clip after clip")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(5, len(labels)))
        save(figure, path)
    return len(series)


def _frame_means(method: Method, frames: ClipTables) -> pd.Series | None:
    tables = [frames[run.id] for run in method.runs if run.id in frames and "psnr" in frames[run.id]]
    return pd.concat(tables).groupby(["scene", "clip", "frame"])["psnr"].mean() if tables else None


def _frame_line(ax: Axes, clips: Sequence[tuple[str, int]], series: dict[str, pd.Series]) -> None:
    """One row of clips; a clip is as wide as its frames, a line divides it from the next, darker between scenes."""
    width = {clip: max(len(_of_clip(values, clip)) for values in series.values()) for clip in clips}
    starts = dict(zip(clips, np.concatenate([[0], np.cumsum([width[clip] for clip in clips])[:-1]])))
    for index, (label, values) in enumerate(series.items()):
        style = DASHES[index // len(COLOURS) % len(DASHES)]
        for clip in clips:
            y = _of_clip(values, clip)
            first = label if clip == clips[0] else None
            ax.plot(starts[clip] + np.arange(len(y)), y, style, color=COLOURS[index % len(COLOURS)], label=first)
    for before, clip in zip((None, *clips), clips):
        new_scene = before is None or before[0] != clip[0]
        ax.axvline(starts[clip] - 0.5, color="0.5" if new_scene else "0.85", linewidth=0.5, zorder=0)
        if new_scene:
            ax.text(starts[clip], 1.0, clip[0], transform=ax.get_xaxis_transform(), fontsize=5, color="0.3")
    ax.set_xlim(-0.5, sum(width.values()) - 0.5)
    ax.set_ylabel("PSNR (dB)")


def _of_clip(values: pd.Series, clip: tuple[str, int]) -> np.ndarray:
    """A clip's values by frame; an infinite PSNR leaves a gap."""
    if clip not in {key[:2] for key in values.index}:
        return np.empty(0)
    y = values.loc[clip].sort_index().to_numpy(dtype=np.float64)
    return np.where(np.isfinite(y), y, np.nan)


def training_figure(found: Sequence[Method], store: Store, path: Path) -> int:
    """Training loss and validation PSNR by step, a line a seed, of as many learned methods as there are colours; returns their
    number."""
    histories = [
        (m.label, [[store.history(run, name) for run in m.runs] for name in ("train/loss", "val/psnr")])
        for m in found[: len(COLOURS)]
    ]
    histories = [(label, both) for label, both in histories if any(any(lines) for lines in both)]
    if not histories:
        return 0
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.4 + 0.1 * len(histories)), layout="constrained")
        axes = figure.subplots(1, 2)
        for index, (label, both) in enumerate(histories):
            for ax, lines in zip(axes, both):
                for seed, points in enumerate(line for line in lines if line):
                    steps, values = zip(*points)
                    name = label if seed == 0 else None
                    ax.plot(np.array(steps), np.array(values), ".-", color=COLOURS[index], alpha=0.8, label=name)
        axes[0].set_yscale("log")
        for ax, title in zip(axes, ("training loss", "validation PSNR (dB)")):
            ax.set_ylabel(title)
            ax.set_xlabel("training step")
        handles, labels = axes[1].get_legend_handles_labels() or axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
        save(figure, path)
    return len(histories)


def front_figure(found: Sequence[Method], clips: ClipTables, path: Path) -> int:
    """PSNR against parameters and against training time; returns how many learned methods are drawn."""
    scored = [(m, value) for m in found if (value := estimate(m.runs, "psnr", clips)) is not None]
    learned = [(m, value) for m, value in scored if m.leading and m.average("model/parameters") > 0]
    if not learned:
        return 0
    labels = short_labels([m.label for m, _ in learned])
    classical = max((value.mean for m, value in scored if m.classical), default=None)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
        axes = figure.subplots(1, 2, sharey=True)
        for ax, metric, title in zip(
            axes, ("model/parameters", "train/minutes"), ("parameters", "minutes of training")
        ):
            points = [(label, m.average(metric), value) for label, (m, value) in zip(labels, learned)]
            scatter(ax, [point for point in points if point[1] > 0])
            if classical is not None:
                ax.axhline(classical, color="0.5", linestyle="--", linewidth=0.7)
            ax.set_xlabel(title)
        axes[0].set_ylabel("PSNR (dB)")
        save(figure, path)
    return len(learned)


def scatter(ax: Axes, points: Sequence[tuple[str, float, Estimate]]) -> None:
    """Named points over a cost, logarithmic if it spans a factor of ten."""
    by_cost = sorted(range(len(points)), key=lambda index: points[index][1:2])
    for place, index in enumerate(by_cost):  # a method has one colour and mark in every panel
        label, cost, value = points[index]
        colour = COLOURS[index % len(COLOURS)]
        ax.plot(cost, value.mean, MARKS[index % len(MARKS)], color=colour, markersize=5)
        above = 5 if place % 2 == 0 else -11
        ax.annotate(label, (cost, value.mean), (0, above), textcoords="offset points", ha="center", color=colour)
    costs = [cost for _, cost, _ in points]
    if costs and max(costs) >= 10 * min(costs):
        ax.set_xscale("log")
    ax.margins(x=0.15, y=0.2)


def save(figure: Figure, path: Path) -> None:
    """As PDF without a date, so that the same runs give the same bytes."""
    FigureCanvasPdf(figure).print_pdf(path, metadata={"CreationDate": None, "Producer": None, "Creator": None})
