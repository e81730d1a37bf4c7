"""A paper's tables of facts, which nothing here competes with."""

from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.reporting.papers.published import name_of, stem_of
from supersampling.reporting.papers.schema import Paper, full_stop


def section(report: Report) -> Section | None:
    """Return a paper's facts; None for the overview, and for a paper without any."""
    if report.subject is None:
        return None
    sheets = fact_sheets(report.subject.paper)
    export(sheets, report.stem)
    return Section(title="Tables of words", sheets=sheets) if sheets else None


def fact_sheets(paper: Paper) -> list[Sheet]:
    """Return the tables of words and of facts about data, as they are in the paper."""
    return [
        Sheet(
            name=f"facts{stem_of(fact.number)}",
            title=full_stop(f"{name_of(fact.number)} {paper.of}"),
            headers=fact.headers,
            rows=[[Text(cell) for cell in row] for row in fact.rows],
            labels=len(fact.headers),
            notes=[full_stop(text) for text in (fact.caption, fact.note, fact.lost) if text],
        )
        for fact in paper.facts
    ]
