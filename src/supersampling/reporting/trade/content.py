"""Quality against time as the template prints it."""

import dataclasses
from pathlib import Path
from typing import Any

from supersampling.reporting.pages.exports import export, rows
from supersampling.reporting.pages.material import Material
from supersampling.reporting.trade import plot as trade_plot
from supersampling.reporting.trade import sheets as trade

CAPTION = (
    "Quality against time. Bars: the 95% interval of the paired difference to the best, and the time's quartiles. The dashed "
    "line is what is reached at each time. The leading configuration of each model is named, at its fastest float32 point."
)


def trade_content(material: Material, stem: Path) -> dict[str, Any]:
    """A figure for each place, tables, and their files; one line where nothing was timed."""
    found = trade.read(material.store, material.experiment, material.found, material.clips)
    if not found.timings:
        return {"note": trade.NOT_MEASURED, "figures": [], "sheets": []}
    items = trade.sheets(found)
    export(items, stem)
    rows(trade.long_form(found), f"{stem}_trade_long.csv")
    figures = []
    for index, place in enumerate(found.places):
        path = Path(f"{stem}_trade_figure{index + 1}.pdf")
        trade_plot.draw(found, place, path)
        figures.append({"file": path.name, "caption": f"{CAPTION} {place}."})
    return {"note": "", "figures": figures, "sheets": [dataclasses.asdict(item) for item in items]}
