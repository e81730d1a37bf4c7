"""Curves of training: what runs logged after every epoch (the thesis's figure 16)."""

from collections.abc import Callable, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from supersampling.reporting.figures.style import colour, dash
from supersampling.runs.store import Run

LABELS = {"train/loss": "training loss", "val/psnr": "validation PSNR (dB)"}
EPOCH = "epoch"  # the metric that Lightning logs beside each of a step
History = Callable[[Run, str], list[tuple[int, float]]]
"""The ``(step, value)`` of a run's metric, by step."""


def by_epoch(run: Run, metric: str, history: History) -> list[tuple[int, float]]:
    """Return ``(epoch, value)`` of a metric that a run logged after each epoch, epochs from 1 up.

    The store keeps steps of the optimizer. A run whose epochs are not in it has as many epochs as logged values.
    """
    points = history(run, metric)
    epochs = dict(history(run, EPOCH))
    if all(step in epochs for step, _ in points):
        return [(int(epochs[step]) + 1, value) for step, value in points]
    return [(index + 1, value) for index, (_, value) in enumerate(points)]


def training_curves(ax: Axes, series: Mapping[str, Sequence[Run]], metric: str, history: History) -> int:
    """Draw a metric over the epochs of training, a line for each seed; return the number of series that logged it."""
    drawn = 0
    for index, (label, members) in enumerate(series.items()):
        curves = [points for run in members if (points := by_epoch(run, metric, history))]
        for seed, points in enumerate(curves):
            epochs, values = zip(*points)
            ax.plot(
                epochs,
                values,
                dash(index),
                marker=".",
                markersize=3,
                color=colour(index),
                alpha=0.8,
                label=label if seed == 0 else None,
            )
        drawn += bool(curves)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("epoch of training")
    return drawn
