"""NSRR's and ENSS's numbers, typed a second time from the papers' text, a line of a table to a line here.

The files may transpose a table or separate its lines of time from those of quality: a line here must be a row, a column
or a cell there, or several rows or columns without a remainder.
"""

import re
from collections import Counter
from itertools import chain, combinations
from pathlib import Path

import pytest

from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.papers.schema import Paper

FOLDER = Path(__file__).resolve().parents[2] / "reports" / "published"

NSRR = {
    # 720p, Rift, 1080p
    "1": """
    Ours       11.96 15.99 24.42
    Ours-Fast   8.84 11.87 18.25
    """,
    "2": """
    Feature extraction       0.97
    Motion vector upsampling 0.25
    Feature zero-upsampling  0.28
    Warping                  0.90
    Feature reweighting      4.73
    Reconstruction           17.2 11.1
    Total                    24.4 18.3
    """,
    "5": """
    PSNR    32.66  34.00  34.92  35.61  36.08
    SSIM    0.9340 0.9505 0.9596 0.9653 0.9696
    Runtime 16.46  21.36  23.19  23.71  24.42
    """,
    "6": """
    PSNR 32.97  34.36  36.08  38.17  41.19
    SSIM 0.9392 0.9538 0.9696 0.9820 0.9928
    """,
    "8": """
    Robots      31.72 0.9142 33.03 0.9250 36.08 0.9696
    Village     27.39 0.7950 28.55 0.8222 30.70 0.9019
    DanceStudio 30.41 0.8418 31.48 0.8584 34.07 0.9224
    Spaceship   32.80 0.9123 33.91 0.9251 36.69 0.9712
    """,
    "9": """
    low, bilinear  34.97 0.9570
    low, zero      35.08 0.9570
    bilinear, high 35.82 0.9658
    zero, high     36.08 0.9696
    """,
    "10": """
    neither     35.63 0.9652
    reweighting 35.76 0.9670
    extraction  35.90 0.9678
    both        36.08 0.9696
    """,
}
ENSS = {
    # Ours-S at 2; Ours-M at 2, 3, 4; Ours-L at 2, 3, 4; Xiao et al. at 2, 3, 4, which has no dilation
    "1": """
    MV dilation    0.21 0.21 0.21 0.21 0.21 0.21 0.21
    Warping        0.15 0.15 0.15 0.15 0.15 0.15 0.15 0.92 0.92 0.92
    Neural network 0.72 1.17 0.81 0.70 3.16 1.74 1.26 13.01 12.92 12.88
    Total          1.08 1.53 1.17 1.06 3.52 2.10 1.62 13.93 13.84 13.80
    """,
    "2": """
    Bicubic    29.51 0.8672 0.219
    DLSS       30.21 0.8816 0.187
    Xiao       31.89 0.9075 0.140
    Ours-S     31.18 0.8941 0.160
    Ours-M     31.80 0.9044 0.140
    Ours-L     32.21 0.9115 0.134
    Bicubic    27.61 0.8034 0.322
    Xiao       30.24 0.8729 0.200
    Ours-M     30.23 0.8655 0.203
    Ours-L     30.67 0.8747 0.187
    Bicubic    26.42 0.7535 0.391
    Xiao       29.02 0.8364 0.259
    Ours-M     29.06 0.8305 0.258
    Ours-L     29.42 0.8403 0.238
    """,
    "3": """
    Baseline          31.80 0.140 37.38 0.54
    no dilation       31.97 0.136 37.47 0.54
    no blending       31.80 0.144 36.86 1.10
    no jitter         31.61 0.153 35.06 0.03
    RAFT              31.09 0.169 35.77 1.21
    no warping        30.69 0.183 37.35 0.53
    one frame         30.56 0.192 33.48 1.96
    no first          31.68 0.145 37.40 0.49
    no last           31.50 0.148 37.38 0.56
    neither           31.26 0.156 37.20 0.56
    two scenes less   31.74 0.144 37.42 0.57
    five scenes less  31.78 0.142 37.14 0.76
    eight scenes less 31.56 0.152 37.11 0.91
    perceptual loss   31.72 0.125 37.40 0.54
    """,
}
SAMPLES = [("nsrr", number, text) for number, text in NSRR.items()]
SAMPLES += [("enss", number, text) for number, text in ENSS.items()]
NUMBER = re.compile(r"(?<![\w.-])\d+\.\d+(?![\w.])")  # all of them have a point


def read(name: str) -> Paper:
    return load_paper(FOLDER / f"{name}.yaml")


def grids(paper: Paper, number: str) -> list[list[list[list[float | None]]]]:
    """``grid[row][column][metric]`` of each table of that number, parts of one (``5b``) included."""
    return [
        [row.values for row in table.rows] for table in paper.tables if re.fullmatch(rf"{number}(\D.*)?", table.number)
    ]


def groups(grid: list[list[list[float | None]]], keys: tuple[tuple[int, ...], ...]) -> list[Counter[float]]:
    """The multisets of what shares its row (0), column (1) and metric (2), as each of ``keys`` names them."""
    found: dict[tuple[object, ...], Counter[float]] = {}
    for row, columns in enumerate(grid):
        for column, values in enumerate(columns):
            for metric, value in enumerate(values):
                if value is not None:
                    place = (row, column, metric)
                    for key in keys:
                        found.setdefault((key, *(place[k] for k in key)), Counter())[value] += 1
    return list(found.values())


def made_of(line: Counter[float], tables: list[list[list[list[float | None]]]]) -> bool:
    """Whether ``line`` is a cell, or one to three rows or columns, whole or of one metric."""
    if any(line == cell for grid in tables for cell in groups(grid, ((0, 1),))):
        return True
    parts = [part for grid in tables for part in groups(grid, ((0,), (1,), (0, 2), (1, 2))) if part <= line]
    sums = (chosen for n in (1, 2, 3) for chosen in combinations(parts, n))
    return any(sum(chosen, Counter()) == line for chosen in sums)


@pytest.mark.parametrize(("name", "number", "text"), SAMPLES, ids=[f"{n} {t}" for n, t, _ in SAMPLES])
def test_a_table_holds_the_lines_typed_here(name: str, number: str, text: str) -> None:
    found = grids(read(name), number)
    typed = [[float(number) for number in NUMBER.findall(line)] for line in text.strip().splitlines()]
    assert all(typed)
    held = Counter(value for grid in found for value in _flat(grid))
    assert Counter(chain.from_iterable(typed)) == held
    if len({len(line) for line in typed}) == 1:  # columns too: nothing has changed places
        typed += [list(column) for column in zip(*typed)]
    for line in typed:
        assert made_of(Counter(line), found), f"{line} is no line of table {number} of {name}"


def _flat(grid: list[list[list[float | None]]]) -> list[float]:
    return [value for columns in grid for value in chain.from_iterable(columns) if value is not None]
