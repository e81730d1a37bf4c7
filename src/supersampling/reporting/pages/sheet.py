"""A typeset table free of any output format, and its Markdown and LaTeX forms."""

from dataclasses import dataclass, field
from typing import Literal

Style = Literal["plain", "bold", "underline", "muted", "yes", "no", "open"]
# Okabe and Ito's blue and vermilion, and a grey: told apart by colour-blind readers. The words say the same.
VERDICT_COLOURS = {"yes": "0072B2", "no": "D55E00", "open": "6B6B6B"}


@dataclass(frozen=True)
class Text:
    """The text of one table cell; ``muted`` is for what is not ours or not there, yes, no and open are verdicts."""

    text: str
    style: Style = "plain"


@dataclass(frozen=True)
class Sheet:
    """A table: ``groups`` are spanning heads (text, columns) above ``headers``; the first ``labels`` columns are labels.

    ``rules`` are the rows that a thin rule stands above.
    """

    name: str
    title: str
    groups: list[tuple[str, int]]
    headers: list[str]
    rows: list[list[Text]]
    labels: int
    notes: list[str] = field(default_factory=list)
    rules: list[int] = field(default_factory=list)


def markdown(sheet: Sheet) -> str:
    """A pipe table; a spanning head goes in front of each of its columns' heads."""
    over = [text for text, span in sheet.groups for _ in range(span)] or [""] * len(sheet.headers)
    heads = [_pipe(f"{group} {head}".strip()) for group, head in zip(over, sheet.headers)]
    align = ["---"] * sheet.labels + ["---:"] * (len(heads) - sheet.labels)
    wrap = {"plain": "{}", "bold": "**{}**", "underline": "<u>{}</u>", "muted": "*{}*"}
    wrap |= dict.fromkeys(VERDICT_COLOURS, "**{}**")
    body = [[wrap[cell.style].format(_pipe(cell.text)) if cell.text else "" for cell in row] for row in sheet.rows]
    lines = [f"| {' | '.join(row)} |" for row in (heads, align, *body)]
    return "\n".join([f"**{_pipe(sheet.title)}**", "", *lines, "", *(f"{note}  " for note in sheet.notes), ""])


def latex(sheet: Sheet) -> str:
    """A ``table`` for the packages booktabs and xcolor."""
    columns = "l" * sheet.labels + "r" * (len(sheet.headers) - sheet.labels)
    lines = [r"\begin{table}", r"\centering", rf"\caption{{{_tex(' '.join([sheet.title, *sheet.notes]))}}}"]
    lines += [rf"\label{{tab:{sheet.name}}}", rf"\begin{{tabular}}{{{columns}}}", r"\toprule"]
    if any(text for text, _ in sheet.groups):
        heads = [rf"\multicolumn{{{span}}}{{c}}{{{_tex(text)}}}" for text, span in sheet.groups]
        lines.append(" & ".join(heads) + r" \\")
    lines += [" & ".join(map(_tex, sheet.headers)) + r" \\", r"\midrule"]
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
        lines.append(" & ".join(wrap[cell.style].format(_tex(cell.text)) for cell in row) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table}", ""])


def _pipe(text: str) -> str:
    return text.replace("\\", "\\\\").replace("|", r"\|").replace("\n", " ")


_TEX = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "±": r"$\pm$", "×": r"$\times$", "−": "$-$", "θ": r"$\theta$", "Δ": r"$\Delta$", "₀": "$_0$", "₁": "$_1$",
    "–": "--", "∞": r"$\infty$", "≥": r"$\geq$", "·": r"$\cdot$", "✓": r"$\surd$", "✗": r"$\times$", "\n": " ",
}  # fmt: skip


def _tex(text: str) -> str:
    return "".join(_TEX.get(character, character) for character in text)
