"""A report's tables as separate files."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from supersampling.reporting.pages.sheet import Sheet, latex, markdown


def export(sheets: Iterable[Sheet], stem: Path) -> None:
    """Write sheets as CSV (as typeset), Markdown and LaTeX."""
    for sheet in sheets:
        typeset = pd.DataFrame([[cell.text for cell in row] for row in sheet.rows], columns=sheet.headers)
        typeset.to_csv(f"{stem}_{sheet.name}.csv", index=False, lineterminator="\n")
        export_words([sheet], stem)


def export_words(sheets: Iterable[Sheet], stem: Path) -> None:
    """Write sheets as Markdown and LaTeX only."""
    for sheet in sheets:
        Path(f"{stem}_{sheet.name}.md").write_text(markdown(sheet), encoding="utf-8")
        Path(f"{stem}_{sheet.name}.tex").write_text(latex(sheet), encoding="utf-8")


def export_rows(rows: Sequence[dict[str, object]], path: str) -> None:
    """Write rows in long form as CSV."""
    pd.DataFrame(rows).to_csv(path, index=False, lineterminator="\n")
