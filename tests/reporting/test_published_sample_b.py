"""The published numbers of NSRD and DLCTUS against a second transcription of a sample, typed from the papers' text.

A block holds a table's numbers line by line as they are printed. The file must hold the same numbers, and each printed
line within one of its rows or columns. Milliseconds in place of microseconds are accepted.
"""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from supersampling.reporting.papers.published import load_paper

PUBLISHED = Path(__file__).resolve().parents[2] / "reports" / "published"

# Table 1, two of its methods: PSNR / SSIM of seven scenes, LPIPS / VMAF of the same, parameters (M) and run time (ms).
NSRD_1 = {
    "NSRR": """
24.62 0.7975
27.52 0.8598
20.66 0.6009
25.51 0.8445
21.82 0.7922
31.75 0.9429
32.57 0.9630
0.281 43.16
0.242 54.62
0.433 19.70
0.318 34.66
0.291 27.54
0.186 56.99
0.064 67.31
0.53
23.94
""",
    "Ours": """
26.43 0.8739
30.37 0.9426
21.58 0.7306
27.16 0.9202
23.63 0.8680
34.09 0.9643
37.03 0.9828
0.141 53.82
0.075 73.50
0.227 26.26
0.087 55.22
0.154 53.38
0.076 70.92
0.029 85.43
1.61
12.41
""",
}
NSRD = {
    "3": "0.84 0.35 0.43 12.41 14.03",
    "6": """
3.5777 3.9011 2.9315
26.05 26.20 26.43
0.8662 0.8711 0.8739
""",
    # The text has one number of each part of the third module.
    "S2": """
2.05 0.26
9.34 1.20
13.86
442.62
84.78
1610.79 145.36
""",
    "S4": """
30.11 26.43 25.18
0.9405 0.8739 0.8349
""",
}
DLCTUS = {
    "1": """
26.35 16.7
15.97 9.46
9.30 2.90
""",
    "6": "127 122 120 369",
    "7": """
358 369 369 369 369 271 2105
358 369 369 369 369 0 1834
198 369 369 369 369 0 1674
""",
    "8": """
569 2105 256 2930
563 2105 277 2945
569 1834 235 2638
563 1834 238 2635
320 1674 152 2146
323 1674 154 2151
""",
    "9": """
26.4 5.2 31.6
33.7 7.0 40.7
33.7 7.0 40.7
""",
    "12": """
241 280 320
243 284 323
""",
}
CASES = [("nsrd", number) for number in NSRD] + [("dlctus", number) for number in DLCTUS]
Grid = list[list[list[float]]]  # row, column, the numbers of a cell
NUMBER = re.compile(r"\s*(-?\d+(?:\.\d+)?)\s*(?:dB|ms|µs|μs|h|min|GB|K|M|%)?\s*")


def parse(block: str) -> list[list[float]]:
    return [[float(x) for x in line.split()] for line in block.strip().splitlines()]


def published(name: str) -> Any:
    return load_paper(PUBLISHED / f"{name}.yaml")


def grids(paper: Any, number: str) -> Iterator[tuple[Grid, Any]]:
    """The tables and facts of a number, parts of it (``1``, ``1b``) too; a fact's label columns are dropped."""
    for table in paper.tables:
        if re.fullmatch(rf"{number}(\D.*)?", str(table.number)):
            yield [[[x for x in cell if x is not None] for cell in row.values] for row in table.rows], table
    for fact in paper.facts:
        if re.fullmatch(rf"{number}(\D.*)?", str(fact.number)):
            cells = [[NUMBER.fullmatch(cell) for cell in row] for row in fact.rows]
            # A factor or a data set is a label though it is a number.
            labels = [all(c is None or c[1] in "123456" for c in column) for column in zip(*cells)]
            yield [[_numbers(c, label) for c, label in zip(row, labels)] for row in cells], fact


def _numbers(cell: re.Match[str] | None, label: bool) -> list[float]:
    return [] if cell is None or label else [float(cell[1])]


def lines_of(grid: Grid) -> list[Counter[float]]:
    """The numbers of each row and of each column."""
    lines = [*grid, *map(list, zip(*grid))]
    return [Counter(x for cell in line for x in cell) for line in lines]


def compare(made: list[Grid], block: list[list[float]]) -> None:
    total = Counter(x for grid in made for row in grid for cell in row for x in cell)
    expected = Counter(x for line in block for x in line)
    if total != expected:  # in thousandths of the unit
        made = [[[[round(1000 * x, 6) for x in cell] for cell in row] for row in grid] for grid in made]
        thousand = Counter(x for grid in made for row in grid for cell in row for x in cell)
        assert thousand == expected, f"second transcription alone: {expected - total}; file alone: {total - expected}"
    lines = [line for grid in made for line in lines_of(grid)]
    for line in block:
        assert any(Counter(line) <= have for have in lines), f"no row or column holds {line}"


@pytest.mark.parametrize(("name", "number"), CASES)
def test_a_table(name: str, number: str) -> None:
    found = [grid for grid, _ in grids(published(name), number)]
    assert found, f"no table {number}"
    compare(found, parse({"nsrd": NSRD, "dlctus": DLCTUS}[name][number]))


@pytest.mark.parametrize("method", NSRD_1)
def test_a_method_of_nsrd_s_table_1(method: str) -> None:
    """Its column, or its row where the methods are rows."""
    found: list[Grid] = []
    for grid, table in grids(published("nsrd"), "1"):
        heads = [column.label for column in table.columns]
        columns = [i for i, label in enumerate(heads) if label.startswith(method)]
        rows = [i for i, row in enumerate(table.rows) if row.labels[-1].startswith(method)]
        assert len(columns) + len(rows) == 1, (heads, [row.labels for row in table.rows])
        found.append([[row[i] for i in columns] for row in grid] if columns else [grid[i] for i in rows])
    compare(found, parse(NSRD_1[method]))


def test_a_slip_is_seen() -> None:
    """A number changed, two exchanged between rows, one left out."""
    block = parse(NSRD["6"])
    good: Grid = [[[x] for x in line] for line in block]
    compare([good], block)
    changed, exchanged = [[list(cell) for cell in row] for row in good], [list(row) for row in good]
    changed[0][1] = [3.9012]
    exchanged[0][0], exchanged[1][1] = good[1][1], good[0][0]
    for bad in (changed, exchanged, good[:2]):
        with pytest.raises(AssertionError):
            compare([bad], block)
