"""Markdown and LaTeX of a small sheet, and the ranking and printing of values."""

import math

import pytest

from supersampling.reporting.format import plus_minus, typeset
from supersampling.reporting.pages.sheet import Sheet, Text, latex, markdown
from supersampling.reporting.papers.schema import Metric
from supersampling.reporting.papers.tables import ranks
from supersampling.runs.statistics import Estimate

SHEET = Sheet(
    name="table2",
    title="100% & more.",
    groups=[("", 1), ("A|B", 2)],
    headers=["loss", "thesis", "ours"],
    rows=[
        [Text("θ_1"), Text("1.0"), Text("2.0 ± 0.1", "bold")],
        [Text("$x"), Text("", "muted"), Text("not run", "muted")],
    ],
    labels=1,
    notes=["Note."],
    rules=[0, 1],
)


def test_markdown_escapes_pipes_and_repeats_the_spanning_head() -> None:
    lines = markdown(SHEET).splitlines()
    assert lines[2] == r"| loss | A\|B thesis | A\|B ours |"
    assert lines[3] == "| --- | ---: | ---: |"
    assert lines[4] == "| θ_1 | 1.0 | **2.0 ± 0.1** |"
    assert lines[5] == "| $x |  | *not run* |"


def test_latex_escapes_and_has_as_many_cells_in_each_line() -> None:
    text = latex(SHEET)
    assert r"\caption{100\% \& more. Note.}" in text
    assert r"$\theta$\_1 & 1.0 & \textbf{2.0 $\pm$ 0.1} \\" in text
    assert r"\$x & \textcolor{gray}{} & \textcolor{gray}{not run} \\" in text
    assert r" & \multicolumn{2}{c}{A|B} \\" in text
    assert text.count(r"\addlinespace") == 1


@pytest.mark.parametrize(
    ("values", "better", "expected"),
    [
        ([30.0, 31.0, 29.0], "higher", ["underline", "bold", "plain"]),
        ([30.0, 31.0, 29.0], "lower", ["underline", "plain", "bold"]),
        ([30.001, 30.002, 29.0], "higher", ["bold", "bold", "underline"]),
        ([30.0, 31.0], "higher", ["plain", "bold"]),
        ([30.0], "higher", ["plain"]),
        ([30.0, 30.0], "higher", ["plain", "plain"]),
    ],
)
def test_ranks_count_values_as_printed(values: list[float], better: str, expected: list[str]) -> None:
    metric = Metric(label="PSNR", unit="dB", better=better, decimals=2, logged="psnr")  # type: ignore[arg-type]
    styles = ranks({(0, index): value for index, value in enumerate(values)}, metric)
    assert [styles[0, index] for index in range(len(values))] == expected


def test_numbers_in_print() -> None:
    assert typeset(plus_minus(Estimate(34.368, 34.1, 34.7, 8), 2)) == "34.37 ± 0.30"
    assert typeset(plus_minus(Estimate(34.368, math.nan, math.nan, 1), 2)) == "34.37"
    assert typeset(plus_minus(Estimate(-0.5, -0.6, -0.4, 8), 1, sign=True)) == "−0.5 ± 0.1"
    assert typeset(plus_minus(Estimate(math.inf, math.nan, math.nan, 2), 2)) == "∞"
