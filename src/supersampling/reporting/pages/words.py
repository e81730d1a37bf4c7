"""A paper's tables of facts and its pictures, which nothing here competes with, and where ours are."""

from supersampling.reporting.pages.exports import export
from supersampling.reporting.pages.report import Report
from supersampling.reporting.pages.section import Section
from supersampling.reporting.pages.sheet import Sheet, Text
from supersampling.reporting.papers.published import name_of, stem_of
from supersampling.reporting.papers.schema import Paper, full_stop

PICTURES = {
    "crops": "see the crops",
    "error_maps": "see the error maps below the crops",
    "epipolar": "see Stability over time",
    "accumulation": "see States",
    "none": "not drawn",
}


def section(report: Report) -> Section | None:
    """Return a paper's facts and pictures; None for the overview, and for a paper without any."""
    if report.subject is None:
        return None
    sheets = [*fact_sheets(report.subject.paper), *picture_sheets(report.subject.paper)]
    export(sheets, report.stem)
    return Section(title="Tables of words and pictures", sheets=sheets) if sheets else None


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


def picture_sheets(paper: Paper) -> list[Sheet]:
    """Return a list of the paper's pictures with the places of ours, as one sheet; none without pictures."""
    rows = [
        [
            Text(name_of(item.number)),
            Text(item.section),
            Text(" ".join(full_stop(text) for text in (item.title, item.note) if text)),
            Text(PICTURES[item.counterpart], "muted" if item.counterpart == "none" else "plain"),
        ]
        for item in paper.pictures
    ]
    title = full_stop(f"Pictures {paper.of}")
    heads = ["where", "section", "what", "ours"]
    return [Sheet(name="pictures", title=title, headers=heads, rows=rows, labels=4)] if rows else []
