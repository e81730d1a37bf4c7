"""The check of a paper's file beyond its numbers: lost cells, facts, pictures, figures, claims."""

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from supersampling.errors import UserError
from supersampling.reporting.papers.published import load_paper, load_papers, name_of, stem_of, sweep_of
from supersampling.reporting.papers.schema import Paper

SMALL: dict[str, Any] = {
    "paper": "small",
    "title": "A paper",
    "authors": "A. One, B. Two",
    "source": "1999",
    "short": "One et al.",
    "metrics": {
        "psnr": {"label": "PSNR", "unit": "dB", "better": "higher", "decimals": 2, "logged": "psnr"},
        "layer": {"label": "time", "unit": "ms", "better": "lower", "decimals": 1, "logged": None},
    },
    "tables": [
        {
            "number": "S1",
            "section": "1",
            "page": 1,
            "title": "Quality.",
            "compare": "row",
            "headers": ["scene"],
            "base": {},
            "lost": "The second column is lost.",
            "columns": [
                {"label": "A", "select": {"model": "a"}, "metrics": ["psnr"]},
                {"label": "B", "select": None, "metrics": ["psnr"]},
            ],
            "rows": [
                {"labels": ["x"], "select": {"task.scale": 4}, "values": [[30.0], [None]]},
                {"labels": ["y"], "select": None, "values": [[31.0], [None]]},
            ],
        }
    ],
    "facts": [
        {"number": "2", "section": "1", "page": 1, "title": "Scenes.", "headers": ["a", "b"], "rows": [["x", ""]]}
    ],
    "pictures": [
        {
            "number": "figure 3",
            "section": "1",
            "page": 1,
            "title": "Crops.",
            "counterpart": "crops",
            "series": [{"label": "A", "select": {"model": "a"}}],
        }
    ],
    "figures": [
        {
            "number": "4",
            "section": "1",
            "page": 1,
            "title": "Curve.",
            "kind": "curve",
            "sweep": None,
            "metric": "psnr",
            "x": "frame",
            "base": {},
            "series": [{"label": "A", "select": {"model": "a"}}],
        }
    ],
    "claims": [
        {
            "id": "small-1",
            "text": "A is better.",
            "source": "Table S1",
            "page": 1,
            "kind": "more",
            "metric": "psnr",
            "unit": "dB",
            "base": {},
            "a": {"model": "a"},
            "b": {"model": "b"},
            "published": None,
        },
        {
            "id": "small-2",
            "text": "More is better.",
            "source": "Table S1",
            "page": 1,
            "kind": "rises",
            "metric": "psnr",
            "unit": "dB",
            "steps": [{"label": "1", "select": {"n": 1}}, {"label": "2", "select": {"n": 2}}],
            "a": {"n": 2},
            "b": {"n": 1},
        },
    ],
}


def load(folder: Path, raw: dict[str, Any]) -> Paper:
    (folder / "small.yaml").write_text(yaml.safe_dump(raw, allow_unicode=True), encoding="utf-8")
    return load_paper(folder / "small.yaml")


def test_optional_and_empty_entries(tmp_path: Path) -> None:
    paper = load(tmp_path, SMALL)
    assert paper.tables[0].rows[0].values == [[30.0], [None]]
    assert paper.tables[0].rows[1].select is None
    assert paper.metrics["layer"].logged is None
    assert sweep_of(paper.tables[0], paper) == "small_tableS1"
    assert list(paper.claims[1].selections) == ["1", "2"]
    assert paper.claims[0].selections == {"b": {"model": "b"}, "a": {"model": "a"}}
    for part in ("facts", "pictures", "figures", "claims"):
        assert getattr(load(tmp_path, {k: v for k, v in SMALL.items() if k != part}), part) == []
        assert getattr(load(tmp_path, {**SMALL, part: []}), part) == []


def test_a_table_without_a_sweep(tmp_path: Path) -> None:
    raw = copy.deepcopy(SMALL)
    raw["tables"][0]["file"] = None
    paper = load(tmp_path, raw)
    assert sweep_of(paper.tables[0], paper) is None


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("tables", 0, "number"), 2, 'number: Invalid value 2: use a text, written as "2"'),
        (("tables", 0, "lost"), "", "has a null: say in lost what is missing"),
        (("tables", 0, "source"), "thesis", "Invalid value 'thesis': choose one of"),
        (("facts", 0, "rows"), [["x"]], "use a cell for each"),
        (("facts", 0, "rows"), [["x", 3]], 'Invalid value 3: use a text, written as "3"'),
        (("pictures", 0, "counterpart"), "film", "film"),
        (("pictures", 0, "counterpart"), "none", "Invalid series of counterpart=none: name the runs"),
        (("pictures", 0, "series"), [], "Invalid series of counterpart=crops: name the runs"),
        (("pictures", 0, "page"), -1, "figure 3: Invalid page=-1: use at least 1"),
        (("figures", 0, "x"), None, "Missing x of a curve"),
        (("figures", 0, "kind"), "pie", "pie"),
        (("claims", 0, "id"), "other-1", "Invalid id=other-1: begin it with small-"),
        (("claims", 1, "id"), "small-1", "small-1 more than once"),
        (("claims", 0, "kind"), "same", "Invalid margin=None of kind=same: use a positive one for same"),
        (("claims", 0, "margin"), 0.1, "Invalid margin=0.1 of kind=more: .* none for others"),
        (("claims", 0, "b"), {"model": "a"}, "the same selection"),
        (("claims", 0, "kind"), "falls", "Too few steps of kind=falls: use at least two"),
        (("claims", 1, "kind"), "more", "Invalid sides of kind=more: use a and b, and no steps"),
        (("claims", 1, "a"), {"n": 7}, "Invalid a or b: use the last step as a"),
        (("claims", 0, "published"), "0.26 dB", "Invalid value '0.26 dB': use a number"),
        (("claims", 0, "a"), {"model": ["a"]}, "run parameters"),
    ],
)
def test_wrong_entry_is_reported_with_its_place(
    tmp_path: Path, place: tuple[Any, ...], value: Any, message: str
) -> None:
    raw = copy.deepcopy(SMALL)
    entry: Any = raw
    for key in place[:-1]:
        entry = entry[key]
    entry[place[-1]] = value
    with pytest.raises(UserError, match=message) as error:
        load(tmp_path, raw)
    assert "small.yaml" in str(error.value)


def test_all_papers_of_a_folder_or_one(tmp_path: Path) -> None:
    load(tmp_path, SMALL)
    (tmp_path / "another.yaml").write_text(
        yaml.safe_dump({**SMALL, "paper": "another", "claims": []}), encoding="utf-8"
    )
    assert [paper.paper for paper in load_papers(tmp_path, None)] == ["another", "small"]
    assert [paper.paper for paper in load_papers(tmp_path, "small")] == ["small"]
    with pytest.raises(UserError, match="no published numbers"):
        load_papers(tmp_path / "none", None)


def test_names_in_print_and_of_files() -> None:
    assert name_of("S2") == "Table S2"
    assert name_of("11a", "Figure") == "Figure 11a"
    assert name_of("colour space") == "Colour space"
    assert stem_of("colour space") == "colour_space"


def test_a_picture_without_a_counterpart_says_why(tmp_path: Path) -> None:
    picture = {"number": "figure 3", "section": "1", "title": "Film.", "counterpart": "none"}
    with pytest.raises(UserError, match="figure 3: Missing note of counterpart=none: say why"):
        load(tmp_path, {**SMALL, "pictures": [picture]})
    assert load(tmp_path, {**SMALL, "pictures": [{**picture, "note": "No film."}]}).pictures[0].series == []
