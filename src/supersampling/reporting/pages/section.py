"""A section of a report as the template prints it: words, claims, figures, tables and galleries of pictures."""

from dataclasses import dataclass, field
from typing import Any

from supersampling.reporting.pages.sheet import Sheet, Text


@dataclass(frozen=True)
class Figure:
    """A figure's file beside the report, empty if nothing could be drawn, and its caption."""

    file: str
    caption: str


@dataclass(frozen=True)
class Picture:
    """A picture's file beside the report, printed pixel by pixel."""

    picture: str


@dataclass(frozen=True)
class GalleryRow:
    """One or more lines of pictures and texts with a label to their left, upright if there are several lines."""

    label: str
    lines: list[list[Picture | Text]]


@dataclass(frozen=True)
class Gallery:
    """Pictures in columns of equal width.

    ``heads`` name the columns; without them the rows have no labels either, and the gallery stays on one page.
    ``share`` is its part of the text's width.
    """

    heads: list[str]
    rows: list[GalleryRow]
    caption: list[Text]
    share: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section: its parts are printed in the order of the attributes; empty ones are left out.

    Attributes:
        words: the paragraph below the title.
        claims: groups of judged claims (`supersampling.reporting.pages.claims`).
        size: of the tables' type, in points.
        remark: the paragraph at the end.
    """

    title: str
    words: list[Text] = field(default_factory=list)
    claims: list[dict[str, Any]] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)
    sheets: list[Sheet] = field(default_factory=list)
    galleries: list[Gallery] = field(default_factory=list)
    remark: str = ""
    size: float = 8.0
