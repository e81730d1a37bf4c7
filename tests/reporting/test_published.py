"""The published numbers, typed a second time from the thesis's text, and the check of their file."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from supersampling.errors import UserError
from supersampling.reporting.papers.published import load_paper
from supersampling.reporting.papers.schema import Paper

FILE = Path(__file__).resolve().parents[2] / "reports" / "published" / "dlctus.yaml"

# Thesis text, row by row: factor, data set, then "PSNR dB / SSIM" of each column.
TABLE_2 = """
4 1 30.04/0.8046 31.73/0.8830 34.18/0.9201 35.49/0.9376
2 1 34.26/0.9104 35.65/0.9484 38.21/0.9645 38.22/0.9625
2 2 31.78/0.8528 33.82/0.9188 35.40/0.9376 35.89/0.9364
"""
TABLE_13 = """
4 1 34.02/0.9080 35.27/0.9370 35.49/0.9376
2 1 36.54/0.9429 38.26/0.9635 38.22/0.9625
2 2 34.32/0.9064 35.92/0.9380 35.89/0.9364
"""
TABLE_14 = """
4 1 35.14/0.9303 35.49/0.9376
2 1 38.26/0.9620 38.22/0.9625
2 2 35.89/0.9356 35.89/0.9364
"""
TABLE_16 = """
4 1 35.49/0.9376 35.23/0.9347
2 2 35.89/0.9365 35.80/0.9359
"""
TABLE_10 = """
0.0166 0.00586 35.89 93.65
0.0166 0.00585 35.90 93.60
0.0166 0.00574 35.87 93.58
0.0179 0.00552 35.36 92.78
"""


@pytest.fixture(scope="module")
def paper() -> Paper:
    return load_paper(FILE)


@pytest.mark.parametrize(("number", "text"), [("2", TABLE_2), ("13", TABLE_13), ("14", TABLE_14), ("16", TABLE_16)])
def test_psnr_and_ssim_tables(paper: Paper, number: str, text: str) -> None:
    table = next(table for table in paper.tables if table.number == number)
    lines = [line.split() for line in text.strip().splitlines()]
    assert len(lines) == len(table.rows)
    for (factor, dataset, *cells), row in zip(lines, table.rows):
        assert row.labels == [f"{factor}×{factor}", dataset]
        assert row.select == {"task.scale": factor, "task.mip_bias": {"1": "matched", "2": "sharp"}[dataset]}
        assert row.values == [[float(x) for x in cell.split("/")] for cell in cells]


def test_loss_table(paper: Paper) -> None:
    table = next(table for table in paper.tables if table.number == "10")
    lines = [[float(x) for x in line.split()] for line in TABLE_10.strip().splitlines()]
    assert [[value for (value,) in row.values] for row in table.rows] == lines
    assert [row.select.get("loss.theta") for row in table.rows] == [None, "0.1", "0.5", "0.9"]
    metrics = [paper.metrics[name] for column in table.columns for name in column.metrics]
    assert [metric.better for metric in metrics] == ["lower", "lower", "higher", "higher"]


def test_pages_are_those_of_the_sections(paper: Paper) -> None:
    contents = {
        "5.3.1": 34, "5.3.3": 43, "5.4.1": 43, "5.4.2": 44, "5.5.1": 44, "5.5.2": 47, "5.5.3": 48,
    }  # fmt: skip
    assert {table.section: table.page for table in paper.tables} == contents


def _set(raw: Any, path: tuple[Any, ...], value: Any) -> None:
    for key in path[:-1]:
        raw = raw[key]
    raw[path[-1]] = value


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("tables", 0, "page"), "p. 34", "page: Invalid value 'p. 34': use a whole number"),
        (("tables", 0, "number"), "10", "table numbers: 10 more than once"),
        (("tables", 0, "rows", 0, "values", 1), [31.73], "Invalid values=.* of row .*4×4.*: use .* numbers by column"),
        (("tables", 0, "rows", 0, "values", 1), ["31.73 dB", 0.88], "Invalid value '31.73 dB': use a number"),
        (("tables", 0, "columns", 0, "metrics"), ["vmaf", "psnr"], "vmaf"),
        (("tables", 0, "compare"), "diagonal", "diagonal"),
        (("metrics", "psnr", "better"), "bigger", "bigger"),
        (("colour",), "red", "colour"),
        (("tables", 0, "rows"), [], "not empty"),
    ],
)
def test_wrong_file_is_reported_with_its_place(tmp_path: Path, path: tuple[Any, ...], value: Any, message: str) -> None:
    raw = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    _set(raw, path, value)
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(yaml.safe_dump(raw, allow_unicode=True), encoding="utf-8")
    with pytest.raises(UserError, match=message):
        load_paper(wrong)


def test_a_file_that_is_missing_or_no_yaml(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no published numbers"):
        load_paper(tmp_path / "none.yaml")
    (tmp_path / "broken.yaml").write_text("tables: [", encoding="utf-8")
    with pytest.raises(UserError, match="Invalid YAML in .*broken.yaml"):
        load_paper(tmp_path / "broken.yaml")
