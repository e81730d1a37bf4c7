"""A report's tables as files of their own."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from supersampling.reporting.pages import sheet
from supersampling.reporting.pages.sheet import Sheet


def export(items: Iterable[Sheet], stem: Path) -> None:
    """Sheets as CSV (as typeset), Markdown and LaTeX."""
    for item in items:
        typeset = pd.DataFrame([[cell.text for cell in row] for row in item.rows], columns=item.headers)
        typeset.to_csv(f"{stem}_{item.name}.csv", index=False, lineterminator="\n")
        words([item], stem)


def words(items: Iterable[Sheet], stem: Path) -> None:
    for item in items:
        Path(f"{stem}_{item.name}.md").write_text(sheet.markdown(item), encoding="utf-8")
        Path(f"{stem}_{item.name}.tex").write_text(sheet.latex(item), encoding="utf-8")


def rows(values: Sequence[dict[str, object]], path: str) -> None:
    pd.DataFrame(values).to_csv(path, index=False, lineterminator="\n")
