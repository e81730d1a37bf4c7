"""The sections of a report in their order, and all that the template prints."""

import dataclasses
from collections.abc import Callable
from typing import Any

from supersampling.reporting.figures import compared, crops, epipolar, published, states
from supersampling.reporting.figures import methods as method_figures
from supersampling.reporting.pages import advice, claims, dataset, methods, stress, tables, words
from supersampling.reporting.pages.appendix import appendix
from supersampling.reporting.pages.dataset import header
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.trade import section as trade

# Each writes its files and returns its section, or None if the report has none of the kind.
MAKERS: tuple[Callable[[Report], Section | None], ...] = (
    claims.section,
    methods.section,
    trade.section,
    tables.section,
    published.section,
    compared.section,
    method_figures.section,
    crops.section,
    epipolar.section,
    states.section,
    words.section,
    dataset.section,
    stress.section,
    advice.section,
)


def content(report: Report) -> dict[str, Any]:
    """Return what the template prints, and write the report's tables and figures as separate files."""
    sections = [section for make in MAKERS if (section := make(report)) is not None]
    return {
        **_title(report),
        "sections": [dataclasses.asdict(section) for section in sections],
        **appendix(report.cells, report.keys, report.material),
        # Last, since it counts the runs that could not be read above.
        "facts": header(report.material, report.runs),
    }


def _title(report: Report) -> dict[str, str]:
    if report.subject is None:
        return {
            "title": "All methods and all claims",
            "subtitle": "What our runs say of the papers",
            "byline": "; ".join(item.paper.title for item in report.material.papers),
        }
    paper = report.subject.paper
    return {
        "title": paper.title,
        "subtitle": "Our runs beside the published numbers",
        "byline": f"{paper.authors}, {paper.source}",
    }
