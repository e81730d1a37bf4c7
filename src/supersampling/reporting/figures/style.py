"""The style of vector figures: colours, marks, type, and how they are saved.

Colours are those of Okabe and Ito (grey for their yellow), for colour-blind readers.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.figure import Figure

from supersampling.runs.statistics import Estimate

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000", "#7F7F7F")
MARKS = "osD^vP*X"
DASHES = ("-", "--", "-.", ":")
STYLE: dict[Any, Any] = {
    "font.size": 7,
    "font.family": "DejaVu Sans",
    "axes.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
    "pdf.fonttype": 42,
}
# Inches.
WIDTH = 6.7


def colour(index: int) -> str:
    return COLOURS[index % len(COLOURS)]


def mark(index: int) -> str:
    return MARKS[index % len(MARKS)]


def dash(index: int) -> str:
    """Return the line style of the ``index``-th line: another one each time that the colours repeat."""
    return DASHES[index // len(COLOURS) % len(DASHES)]


def scatter(ax: Axes, points: Sequence[tuple[str, float, Estimate]]) -> None:
    """Draw named points over a cost, on a logarithmic axis if they span a factor of ten."""
    by_cost = sorted(range(len(points)), key=lambda index: points[index][1:2])
    # A method has the same colour and mark in every panel.
    for place, index in enumerate(by_cost):
        label, cost, value = points[index]
        ax.plot(cost, value.mean, mark(index), color=colour(index), markersize=5)
        above = 5 if place % 2 == 0 else -11
        ax.annotate(label, (cost, value.mean), (0, above), textcoords="offset points", ha="center", color=colour(index))
    costs = [cost for _, cost, _ in points]
    if costs and max(costs) >= 10 * min(costs):
        ax.set_xscale("log")
    ax.margins(x=0.15, y=0.2)


def save(figure: Figure, path: Path) -> None:
    """Write a PDF without a date, so that the same runs give the same bytes."""
    FigureCanvasPdf(figure).print_pdf(path, metadata={"CreationDate": None, "Producer": None, "Creator": None})
