"""Quality against time as a vector figure: a method a colour, a backend a mark, labels where there is room for them."""

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from supersampling.reporting.figures.figures import COLOURS, MARKS, STYLE, WIDTH, save
from supersampling.reporting.pages.overview import short_labels
from supersampling.reporting.trade.front import EXACT, Candidate, Place, front
from supersampling.reporting.trade.sheets import Trade, best_of

HEIGHT = 3.6
VARIATION = ","  # in a label, before what differs from the leading configuration of its model
# Where a label may stand beside its point, in points of 1/72 inch, the nearest first.
OFFSETS = [
    offset
    for far in (0, 8, 16, 24, 32, 40)
    for offset in ((0, 8 + far), (0, -8 - far), (8, far), (-8, far), (8, -far), (-8, -far))
]  # fmt: skip


def draw(trade: Trade, place: Place, path: Path) -> bool:
    """Write one place's figure as PDF; false where there is nothing to draw."""
    found = trade.at(place)
    if not found:
        return False
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        ax = figure.subplots()
        labels = list(dict.fromkeys(one.label for one in found))
        colours = {label: COLOURS[k % len(COLOURS)] for k, label in enumerate(sorted(labels))}
        _points(ax, trade, found, colours)
        _line(ax, front(found))
        ax.set_xscale("log")
        ax.margins(x=0.12, y=0.12)
        _ticks(ax)
        ax.set_xlabel(f"milliseconds a frame, {place.width}x{place.height}, {place.device}")
        ax.set_ylabel("PSNR (dB)")
        _legend(figure, found)
        figure.canvas = FigureCanvasAgg(figure)
        figure.draw_without_rendering()
        # The shortest label of a model is its leading configuration's: the others say what differs.
        leading = list({x.split(VARIATION)[0].split()[0]: x for x in sorted(labels, key=len, reverse=True)}.values())
        _names(ax, found, dict(zip(leading, short_labels(leading))), colours)
        save(figure, path)
    return True


def _points(ax: Axes, trade: Trade, found: Sequence[Candidate], colours: dict[str, str]) -> None:
    """Mark, time's quartiles, and what the data leave open of the paired difference to the best."""
    best, marks = best_of(found), _marks(found)
    for one in found:
        colour, mean = colours[one.label], one.quality.mean
        gap = trade.gap(one, best)
        if gap is not None and math.isfinite(gap.half_width) and gap.half_width > 0:
            ax.errorbar(
                one.ms, mean, [[gap.mean - gap.low], [gap.high - gap.mean]], color=colour, linewidth=0.6, capsize=1.5,
                alpha=0.6,
            )  # fmt: skip
        if math.isfinite(one.timing.low) and math.isfinite(one.timing.high):
            ax.plot([one.timing.low, one.timing.high], [mean, mean], color=colour, linewidth=0.6, alpha=0.6)
        face = colour if one.timing.precision == EXACT else "white"
        ax.plot(
            one.ms, mean, marks[one.timing.backend], color=colour, markersize=4.5, markerfacecolor=face,
            markeredgewidth=0.9, zorder=3,
        )  # fmt: skip


def _marks(found: Sequence[Candidate]) -> dict[str, str]:
    backends = sorted({one.timing.backend for one in found})
    return {name: MARKS[k % len(MARKS)] for k, name in enumerate(backends)}


def _line(ax: Axes, on: Sequence[Candidate]) -> None:
    """The front as stairs: what is reached at each time."""
    ax.plot(
        [one.ms for one in on], [one.quality.mean for one in on], color="0.45", linewidth=0.8, linestyle="--", zorder=1,
        drawstyle="steps-post",
    )  # fmt: skip


def _ticks(ax: Axes) -> None:
    """Plain numbers, 1, 2 and 5 of each power of ten."""
    low, high = ax.get_xlim()
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    at = [step * 10.0**power for power in range(first, last + 1) for step in (1, 2, 5)]
    shown = [x for x in at if low <= x <= high]
    ax.set_xticks(shown, [f"{x:g}" for x in shown])
    ax.set_xticks([], minor=True)
    ax.grid(axis="both", color="0.92", linewidth=0.4)
    ax.set_axisbelow(True)


def _legend(figure: Figure, found: Sequence[Candidate]) -> None:
    marks = _marks(found)
    handles = [
        Line2D([], [], color="0.3", marker=mark, linestyle="", markersize=4, label=name) for name, mark in marks.items()
    ]
    if any(one.timing.precision != EXACT for one in found):
        handles.append(
            Line2D([], [], color="0.3", marker="o", linestyle="", markersize=4, markerfacecolor="white",
                   label="lower precision")
        )  # fmt: skip
    handles.append(Line2D([], [], color="0.45", linestyle="--", label="front"))
    figure.legend(handles=handles, loc="outside upper center", ncols=min(8, len(handles)))


def _names(ax: Axes, found: Sequence[Candidate], short: dict[str, str], colours: dict[str, str]) -> None:
    """Each name once, at the method's fastest point in float32, where it covers no mark and no other name."""
    pixels = ax.figure.dpi / 72  # of a point
    centres = [ax.transData.transform((one.ms, one.quality.mean)) for one in found]
    taken = [Bbox.from_extents(x - 3 * pixels, y - 3 * pixels, x + 3 * pixels, y + 3 * pixels) for x, y in centres]
    frame = ax.get_window_extent()
    named: set[str] = set()
    for one, (x, y) in sorted(zip(found, centres), key=lambda pair: (pair[0].timing.precision != EXACT, pair[0].ms)):
        if one.label in named or one.label not in short:
            continue
        named.add(one.label)
        text = ax.annotate(
            short[one.label], (one.ms, one.quality.mean), OFFSETS[0], textcoords="offset points", fontsize=6,
            color="0.15", va="center", annotation_clip=False,
        )  # fmt: skip
        size = text.get_window_extent()
        box = _free(x, y, size.width, size.height, pixels, taken, frame)
        taken.append(box)
        text.set_position(((box.x0 - x) / pixels, (box.y0 + box.y1 - 2 * y) / 2 / pixels))
        if abs((box.y0 + box.y1) / 2 - y) > 12 * pixels:  # far off: a thin line leads to the point
            end = ax.transData.inverted().transform((min(max(x, box.x0), box.x1), box.y0 if box.y0 > y else box.y1))
            ax.plot([one.ms, end[0]], [one.quality.mean, end[1]], color=colours[one.label], linewidth=0.3)


def _free(x: float, y: float, width: float, height: float, pixels: float, taken: Sequence[Bbox], frame: Bbox) -> Bbox:
    """The first place that covers nothing; else the one that covers least."""
    boxes = []
    for dx, dy in OFFSETS:
        left = x + dx * pixels - (0 if dx > 0 else width if dx < 0 else width / 2)
        middle = y + dy * pixels
        boxes.append(Bbox.from_extents(left, middle - height / 2, left + width, middle + height / 2))

    def covered(box: Bbox) -> float:
        outside = not (frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1)
        shared = (Bbox.intersection(box, other) for other in taken)
        return sum(b.width * b.height for b in shared if b is not None) + (1e6 if outside else 0.0)

    return min(boxes, key=covered)
