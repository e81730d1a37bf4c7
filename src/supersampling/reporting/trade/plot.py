"""Quality against time as a vector figure: a colour per method, a mark per backend, labels where there is room."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from supersampling.reporting.figures.style import STYLE, WIDTH, colour, mark, save
from supersampling.reporting.methods import short_labels
from supersampling.reporting.trade.front import EXACT, Candidate, Place, front
from supersampling.reporting.trade.sheets import Trade, best_of

HEIGHT = 3.6
# Stands in a label before what differs from the leading configuration of its model.
VARIATION = ","
# Offsets of a label from its point, in points of 1/72 inch, the nearest first.
OFFSETS = [
    offset
    for far in (0, 8, 16, 24, 32, 40)
    for offset in ((0, 8 + far), (0, -8 - far), (8, far), (-8, far), (8, -far), (-8, -far))
]


def draw(trade: Trade, place: Place, path: Path) -> bool:
    """Write one place's figure as PDF; return False if there is nothing to draw."""
    candidates = trade.at_place(place)
    if not candidates:
        return False
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        ax = figure.subplots()
        labels = list(dict.fromkeys(candidate.label for candidate in candidates))
        colours = {label: colour(k) for k, label in enumerate(sorted(labels))}
        _draw_points(ax, trade, candidates, colours)
        _draw_front(ax, front(candidates))
        ax.set_xscale("log")
        ax.margins(x=0.12, y=0.12)
        _set_ticks(ax)
        ax.set_xlabel(f"milliseconds per frame, {place.width}x{place.height}, {place.device}")
        ax.set_ylabel("PSNR (dB)")
        _add_legend(figure, candidates)
        figure.canvas = FigureCanvasAgg(figure)
        figure.draw_without_rendering()
        # The shortest label of a model is its leading configuration's: the others say what differs.
        leading = list({x.split(VARIATION)[0].split()[0]: x for x in sorted(labels, key=len, reverse=True)}.values())
        _add_names(ax, candidates, dict(zip(leading, short_labels(leading))), colours)
        save(figure, path)
    return True


def _draw_points(ax: Axes, trade: Trade, candidates: Sequence[Candidate], colours: dict[str, str]) -> None:
    """Draw the marks, the times' quartiles, and the intervals of the paired differences to the best."""
    best, marks = best_of(candidates), _marks(candidates)
    for candidate in candidates:
        paint, ms, mean, timing = colours[candidate.label], candidate.ms, candidate.quality.mean, candidate.timing
        gap = trade.gap(candidate, best)
        if gap is not None and math.isfinite(gap.half_width) and gap.half_width > 0:
            ends = [[gap.mean - gap.low], [gap.high - gap.mean]]
            ax.errorbar(ms, mean, ends, color=paint, linewidth=0.6, capsize=1.5, alpha=0.6)
        if math.isfinite(timing.low) and math.isfinite(timing.high):
            ax.plot([timing.low, timing.high], [mean, mean], color=paint, linewidth=0.6, alpha=0.6)
        ax.plot(
            ms,
            mean,
            marks[timing.backend],
            color=paint,
            markersize=4.5,
            markerfacecolor=paint if timing.precision == EXACT else "white",
            markeredgewidth=0.9,
            zorder=3,
        )


def _marks(candidates: Sequence[Candidate]) -> dict[str, str]:
    backends = sorted({candidate.timing.backend for candidate in candidates})
    return {name: mark(k) for k, name in enumerate(backends)}


def _draw_front(ax: Axes, candidates: Sequence[Candidate]) -> None:
    """Draw the front as stairs: the quality that is reached at each time."""
    times, qualities = [c.ms for c in candidates], [c.quality.mean for c in candidates]
    ax.plot(times, qualities, color="0.45", linewidth=0.8, linestyle="--", zorder=1, drawstyle="steps-post")


def _set_ticks(ax: Axes) -> None:
    """Set ticks with plain numbers: 1, 2 and 5 of each power of ten."""
    low, high = ax.get_xlim()
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    steps = [step * 10.0**power for power in range(first, last + 1) for step in (1, 2, 5)]
    ticks = [x for x in steps if low <= x <= high]
    ax.set_xticks(ticks, [f"{x:g}" for x in ticks])
    ax.set_xticks([], minor=True)
    ax.grid(axis="both", color="0.92", linewidth=0.4)
    ax.set_axisbelow(True)


def _add_legend(figure: Figure, candidates: Sequence[Candidate]) -> None:
    look: dict[str, Any] = {"color": "0.3", "linestyle": "", "markersize": 4}
    handles = [Line2D([], [], marker=shape, label=name, **look) for name, shape in _marks(candidates).items()]
    if any(candidate.timing.precision != EXACT for candidate in candidates):
        handles.append(Line2D([], [], marker="o", markerfacecolor="white", label="lower precision", **look))
    handles.append(Line2D([], [], color="0.45", linestyle="--", label="front"))
    figure.legend(handles=handles, loc="outside upper center", ncols=min(8, len(handles)))


def _add_names(ax: Axes, candidates: Sequence[Candidate], names: dict[str, str], colours: dict[str, str]) -> None:
    """Write each name once, at the method's fastest point in float32, where it covers no mark and no other name."""
    pixels_per_point = ax.figure.dpi / 72
    centres = [ax.transData.transform((c.ms, c.quality.mean)) for c in candidates]
    mark_size = 3 * pixels_per_point
    occupied = [Bbox.from_extents(x - mark_size, y - mark_size, x + mark_size, y + mark_size) for x, y in centres]
    frame = ax.get_window_extent()
    seen: set[str] = set()
    by_time = sorted(zip(candidates, centres), key=lambda pair: (pair[0].timing.precision != EXACT, pair[0].ms))
    for candidate, (x, y) in by_time:
        label, point = candidate.label, (candidate.ms, candidate.quality.mean)
        if label in seen or label not in names:
            continue
        seen.add(label)
        text = ax.annotate(
            names[label],
            point,
            OFFSETS[0],
            textcoords="offset points",
            fontsize=6,
            color="0.15",
            va="center",
            annotation_clip=False,
        )
        box = _free_box(x, y, text.get_window_extent(), pixels_per_point, occupied, frame)
        occupied.append(box)
        text.set_position(((box.x0 - x) / pixels_per_point, (box.y0 + box.y1 - 2 * y) / 2 / pixels_per_point))
        # A thin line leads from a distant label to its point.
        if abs((box.y0 + box.y1) / 2 - y) > 12 * pixels_per_point:
            end = ax.transData.inverted().transform((min(max(x, box.x0), box.x1), box.y0 if box.y0 > y else box.y1))
            ax.plot([point[0], end[0]], [point[1], end[1]], color=colours[label], linewidth=0.3)


def _free_box(x: float, y: float, size: Bbox, pixels: float, occupied: Sequence[Bbox], frame: Bbox) -> Bbox:
    """Return the first box beside ``(x, y)`` that covers nothing, else the one that covers least.

    Args:
        size: a box of the label's size.
        pixels: per point of 1/72 inch.
    """
    boxes = []
    for dx, dy in OFFSETS:
        left = x + dx * pixels - (0 if dx > 0 else size.width if dx < 0 else size.width / 2)
        middle = y + dy * pixels
        boxes.append(Bbox.from_extents(left, middle - size.height / 2, left + size.width, middle + size.height / 2))

    def covered(box: Bbox) -> float:
        outside = not (frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1)
        shared = (Bbox.intersection(box, item) for item in occupied)
        return sum(b.width * b.height for b in shared if b is not None) + (1e6 if outside else 0.0)

    return min(boxes, key=covered)
