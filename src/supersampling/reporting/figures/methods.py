"""Figures of the methods themselves: PSNR against cost, training, and every test frame."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from supersampling.reporting.figures.style import COLOURS, STYLE, WIDTH, colour, dash, save, scatter
from supersampling.reporting.figures.training import LABELS
from supersampling.reporting.methods import Method, short_labels
from supersampling.reporting.pages import section as parts
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.runs.estimates import ClipTables, estimate
from supersampling.runs.store import Store

CLIPS_PER_ROW = 10
COSTS = {"model/parameters": "parameters", "train/minutes": "minutes of training"}
Clip = tuple[str, int]


def section(report: Report) -> Section | None:
    """Return the overview's figures; None for a paper, and if nothing can be drawn."""
    if report.subject is not None:
        return None
    material, stem = report.material, report.stem
    learned = [method for method in material.leading if not method.classical]
    front = front_figure(material.methods, material.clips, Path(f"{stem}_front.pdf"))
    frames = frames_figure(material.leading, material.frames, Path(f"{stem}_frames.pdf"))
    trained = training_figure(learned, material.store, Path(f"{stem}_training.pdf"))
    figures = [
        (
            "front",
            front,
            "PSNR over the test set against parameters and minutes of training, for the leading configuration of each "
            "learned method. The dashed line is the best method without parameters.",
        ),
        (
            "training",
            trained,
            f"Training loss and validation PSNR by step, one line per seed, of {trained} of {len(learned)} learned "
            "methods, each in its leading configuration. Losses of different kinds do not compare.",
        ),
        (
            "frames",
            frames,
            "PSNR of every test frame, clip after clip, for the leading configuration of each method, mean over its "
            "seeds.",
        ),
    ]
    drawn = [parts.Figure(f"{stem.name}_{name}.pdf", caption) for name, count, caption in figures if count]
    return Section(title="Figures", figures=drawn) if drawn else None


def frames_figure(methods: Sequence[Method], frames: ClipTables, path: Path) -> int:
    """Draw PSNR of every test frame, clip after clip (the thesis's figure 8); return how many methods have frames."""
    means = [(m.label, s) for m in methods if (s := _frame_means(m, frames)) is not None]
    series = dict(zip(short_labels([label for label, _ in means]), (s for _, s in means)))
    if not series:
        return 0
    clips: list[Clip] = sorted({key[:2] for values in series.values() for key in values.index})
    rows = -(-len(clips) // CLIPS_PER_ROW)
    per_row = -(-len(clips) // rows)
    lines = [clips[i : i + per_row] for i in range(0, len(clips), per_row)]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.35 + 1.55 * len(lines)), layout="constrained")
        axes = figure.subplots(len(lines), 1, squeeze=False, sharey=True)[:, 0]
        for ax, line in zip(axes, lines):
            _frame_line(ax, line, series)
        axes[-1].set_xlabel("frame, clip after clip")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(5, len(labels)))
        save(figure, path)
    return len(series)


def _frame_means(method: Method, frames: ClipTables) -> pd.Series | None:
    tables = [frames[run.id] for run in method.runs if run.id in frames and "psnr" in frames[run.id]]
    return pd.concat(tables).groupby(["scene", "clip", "frame"])["psnr"].mean() if tables else None


def _frame_line(ax: Axes, clips: Sequence[Clip], series: dict[str, pd.Series]) -> None:
    """Draw one row of clips: each as wide as its frames, a line between two of them, a darker one between scenes."""
    width = {clip: max(len(_clip_values(values, clip)) for values in series.values()) for clip in clips}
    starts = dict(zip(clips, np.concatenate([[0], np.cumsum([width[clip] for clip in clips])[:-1]])))
    for index, (label, values) in enumerate(series.items()):
        for clip in clips:
            y = _clip_values(values, clip)
            name = label if clip == clips[0] else None
            ax.plot(starts[clip] + np.arange(len(y)), y, dash(index), color=colour(index), label=name)
    for before, clip in zip((None, *clips), clips):
        new_scene = before is None or before[0] != clip[0]
        ax.axvline(starts[clip] - 0.5, color="0.5" if new_scene else "0.85", linewidth=0.5, zorder=0)
        if new_scene:
            ax.text(starts[clip], 1.0, clip[0], transform=ax.get_xaxis_transform(), fontsize=5, color="0.3")
    ax.set_xlim(-0.5, sum(width.values()) - 0.5)
    ax.set_ylabel("PSNR (dB)")


def _clip_values(values: pd.Series, clip: Clip) -> np.ndarray:
    """Return a clip's values by frame; an infinite PSNR leaves a gap."""
    if clip not in {key[:2] for key in values.index}:
        return np.empty(0)
    y = values.loc[clip].sort_index().to_numpy(dtype=np.float64)
    return np.where(np.isfinite(y), y, np.nan)


def training_figure(methods: Sequence[Method], store: Store, path: Path) -> int:
    """Draw training loss and validation PSNR by step, one line per seed; return the number of methods.

    No more learned methods are drawn than there are colours.
    """
    histories = [
        (m.label, [[store.history(run, name) for run in m.runs] for name in LABELS]) for m in methods[: len(COLOURS)]
    ]
    histories = [(label, curves) for label, curves in histories if any(any(lines) for lines in curves)]
    if not histories:
        return 0
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.4 + 0.1 * len(histories)), layout="constrained")
        axes = figure.subplots(1, 2)
        for index, (label, curves) in enumerate(histories):
            for ax, lines in zip(axes, curves):
                for seed, points in enumerate(line for line in lines if line):
                    steps, values = zip(*points)
                    name = label if seed == 0 else None
                    ax.plot(np.array(steps), np.array(values), ".-", color=COLOURS[index], alpha=0.8, label=name)
        axes[0].set_yscale("log")
        for ax, title in zip(axes, LABELS.values()):
            ax.set_ylabel(title)
            ax.set_xlabel("training step")
        handles, labels = axes[1].get_legend_handles_labels() or axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
        save(figure, path)
    return len(histories)


def front_figure(methods: Sequence[Method], clips: ClipTables, path: Path) -> int:
    """Draw PSNR against parameters and against training time; return the number of learned methods."""
    scored = [(m, value) for m in methods if (value := estimate(m.runs, "psnr", clips)) is not None]
    learned = [(m, value) for m, value in scored if m.leading and not m.classical]
    if not learned:
        return 0
    labels = short_labels([m.label for m, _ in learned])
    classical = max((value.mean for m, value in scored if m.classical), default=None)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.7), layout="constrained")
        axes = figure.subplots(1, 2, sharey=True)
        for ax, (metric, title) in zip(axes, COSTS.items()):
            points = [(label, m.average(metric), value) for label, (m, value) in zip(labels, learned)]
            scatter(ax, [point for point in points if point[1] > 0])
            if classical is not None:
                ax.axhline(classical, color="0.5", linestyle="--", linewidth=0.7)
            ax.set_xlabel(title)
        axes[0].set_ylabel("PSNR (dB)")
        save(figure, path)
    return len(learned)
