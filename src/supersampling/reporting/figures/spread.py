"""How much the leading methods' quality varies over test clips."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from supersampling.reporting.figures.style import STYLE, WIDTH, colour, save
from supersampling.reporting.methods import Method, short_labels
from supersampling.reporting.pages import section as parts
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.runs.estimates import ClipTables, clip_scores


def section(report: Report) -> Section | None:
    """Return the overview's figure; None for a paper, and if no clip was scored."""
    if report.subject is not None:
        return None
    path = Path(f"{report.stem}_spread.pdf")
    if not spread_figure(report.material.leading, report.material.clips, path):
        return None
    caption = "PSNR of every test clip, mean over seeds: a point a clip, for the leading configuration of each method."
    return Section(title="Spread over clips", figures=[parts.Figure(path.name, caption)])


def spread_figure(methods: Sequence[Method], clips: ClipTables, path: Path) -> int:
    """Draw a row of points for each method; return how many methods have scored clips."""
    scored = [
        (m.label, s.mean(axis=1).to_numpy()) for m in methods if (s := clip_scores(m.runs, "psnr", clips)) is not None
    ]
    if not scored:
        return 0
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.7 + 0.25 * len(scored)), layout="constrained")
        ax = figure.subplots()
        for row, (_, values) in enumerate(scored):
            ax.plot(values, [row] * len(values), "|", color=colour(row), markersize=8)
        ax.set_yticks(range(len(scored)), short_labels([label for label, _ in scored]))
        ax.set_ylim(-0.6, len(scored) - 0.4)
        ax.set_xlabel("PSNR (dB)")
        save(figure, path)
    return len(scored)
