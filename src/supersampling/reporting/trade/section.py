"""Quality against time as a section of the overview."""

from pathlib import Path

from supersampling.reporting.pages.exports import export, export_rows
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Figure, Section
from supersampling.reporting.pages.sheet import Text
from supersampling.reporting.trade import plot
from supersampling.reporting.trade.sheets import long_form, read_trade, sheets

TITLE = "Quality against time"
NOT_MEASURED = "No times of these methods were measured yet: python benchmark.py run=all measures them."
CAPTION = (
    "Quality against time. Bars: the 95% interval of the paired difference to the best, and the time's quartiles. The "
    "dashed line is the best quality that is reached at each time. The leading configuration of each model is named, "
    "at its fastest float32 point."
)


def section(report: Report) -> Section | None:
    """Return a figure for each place and tables, a sentence if nothing was timed, None for a paper."""
    if report.subject is not None:
        return None
    material = report.material
    trade = read_trade(material.store, material.experiment, material.methods, material.clips)
    if not trade.timings:
        return Section(title=TITLE, words=[Text(NOT_MEASURED)])
    pages = sheets(trade)
    export(pages, report.stem)
    export_rows(long_form(trade), f"{report.stem}_trade_long.csv")
    figures = []
    for index, place in enumerate(trade.places):
        path = Path(f"{report.stem}_trade_figure{index + 1}.pdf")
        plot.draw(trade, place, path)
        figures.append(Figure(path.name, f"{CAPTION} {place}."))
    return Section(title=TITLE, figures=figures, sheets=pages, size=7.5)
