"""A typeset table independent of any output format, and its Markdown and LaTeX forms."""

from dataclasses import dataclass, field
from typing import Literal

Style = Literal["plain", "bold", "underline", "muted", "yes", "no", "open"]
# Blue and vermilion of Okabe and Ito, and a grey: colour-blind readers can tell them apart. The words say the same.
VERDICT_COLOURS = {"yes": "0072B2", "no": "D55E00", "open": "6B6B6B"}


@dataclass(frozen=True)
class Text:
    """A piece of text, such as a table cell. ``muted`` is for numbers that are not ours or are missing; yes, no and
    open are verdicts."""

    text: str
    style: Style = "plain"


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A table.

    Attributes:
        name: part of its files' names.
        groups: spanning heads above ``headers``, each with its number of columns; empty for none.
        labels: the number of leading columns that hold labels.
        rules: indices of the rows with a thin rule above them.
    """

    name: str
    title: str
    headers: list[str]
    rows: list[list[Text]]
    labels: int = 1
    groups: list[tuple[str, int]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    rules: list[int] = field(default_factory=list)


def markdown(sheet: Sheet) -> str:
    """Return a pipe table; a spanning head is repeated in front of the head of each of its columns."""
    over = [text for text, columns in sheet.groups for _ in range(columns)] or [""] * len(sheet.headers)
    heads = [_escape_pipes(f"{group} {head}".strip()) for group, head in zip(over, sheet.headers)]
    align = ["---"] * sheet.labels + ["---:"] * (len(heads) - sheet.labels)
    wrap = {"plain": "{}", "bold": "**{}**", "underline": "<u>{}</u>", "muted": "*{}*"}
    wrap |= dict.fromkeys(VERDICT_COLOURS, "**{}**")
    body = [
        [wrap[cell.style].format(_escape_pipes(cell.text)) if cell.text else "" for cell in row] for row in sheet.rows
    ]
    lines = [f"| {' | '.join(row)} |" for row in (heads, align, *body)]
    return "\n".join([f"**{_escape_pipes(sheet.title)}**", "", *lines, "", *(f"{note}  " for note in sheet.notes), ""])


def latex(sheet: Sheet) -> str:
    """Return a ``table`` for the packages booktabs and xcolor."""
    columns = "l" * sheet.labels + "r" * (len(sheet.headers) - sheet.labels)
    lines = [r"\begin{table}", r"\centering", rf"\caption{{{_escape_tex(' '.join([sheet.title, *sheet.notes]))}}}"]
    lines += [rf"\label{{tab:{sheet.name}}}", rf"\begin{{tabular}}{{{columns}}}", r"\toprule"]
    if any(text for text, _ in sheet.groups):
        heads = [rf"\multicolumn{{{columns}}}{{c}}{{{_escape_tex(text)}}}" for text, columns in sheet.groups]
        lines.append(" & ".join(heads) + r" \\")
    lines += [" & ".join(map(_escape_tex, sheet.headers)) + r" \\", r"\midrule"]
    wrap = {
        "plain": "{}",
        "bold": r"\textbf{{{}}}",
        "underline": r"\underline{{{}}}",
        "muted": r"\textcolor{{gray}}{{{}}}",
    }
    for style, colour in VERDICT_COLOURS.items():
        wrap[style] = rf"\textcolor[HTML]{{{{{colour}}}}}{{{{{{}}}}}}"
    for index, row in enumerate(sheet.rows):
        if index in sheet.rules and index:
            lines.append(r"\addlinespace")
        lines.append(" & ".join(wrap[cell.style].format(_escape_tex(cell.text)) for cell in row) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}", ""])


def _escape_pipes(text: str) -> str:
    return text.replace("\\", "\\\\").replace("|", r"\|").replace("\n", " ")


_TEX = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "±": r"$\pm$", "×": r"$\times$", "−": "$-$", "θ": r"$\theta$", "Δ": r"$\Delta$", "₀": "$_0$", "₁": "$_1$",
    "–": "--", "∞": r"$\infty$", "≥": r"$\geq$", "·": r"$\cdot$", "✓": r"$\surd$", "✗": r"$\times$", "\n": " ",
}  # fmt: skip


def _escape_tex(text: str) -> str:
    return "".join(_TEX.get(character, character) for character in text)
