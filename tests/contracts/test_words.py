"""Plain words: names, docstrings and lines of the package follow the rules of ``scripts/wording.py``."""

import ast
from pathlib import Path

import pytest
from wording import indirect_docstrings, is_unclear, long_lines, unclear_names

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "supersampling"
FILES = sorted(PACKAGE.rglob("*.py"))
STORED = {("gated.py", "both")}  # the name of weights in checkpoints


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_words_of_file(path: Path) -> None:
    text = path.read_text()
    nodes = list(ast.walk(ast.parse(text)))
    findings = [*unclear_names(nodes), *indirect_docstrings(nodes), *long_lines(text)]
    findings = [finding for finding in findings if (path.name, finding.text) not in STORED]
    assert not findings, "\n".join(f"{path}:{finding.line} {finding.text}" for finding in findings)


def test_file_names() -> None:
    assert [path for path in FILES if is_unclear(path.stem) or is_unclear(path.parent.name)] == []


@pytest.mark.parametrize("name", ["found", "_held", "OURS", "of_one", "every_clip", "let_go", "Chosen"])
def test_unclear_name(name: str) -> None:
    assert is_unclear(name)


@pytest.mark.parametrize("name", ["matches", "one_hot", "none", "done", "foundry", "pretty", "ownership", "chosen2"])
def test_clear_name(name: str) -> None:
    assert not is_unclear(name)


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("for found in range(3): pass", ["found"]),
        ("def read(self, *, given=1): pass", ["given"]),
        ("self.held = 1", ["held"]),
        ("from numpy import take as taken", ["taken"]),
        ("class Clip:\n    own: int", ["own"]),
        ("class Clip:\n    def __eq__(self, other): pass", []),
        ("print(found)", []),
        ("def test_found(): pass", []),
        ("match x:\n    case [*made]: pass", ["made"]),
    ],
)
def test_definitions_are_checked_and_uses_are_not(code: str, names: list[str]) -> None:
    assert [finding.text for finding in unclear_names(list(ast.walk(ast.parse(code))))] == names


@pytest.mark.parametrize(
    ("docstring", "count"), [("What is read.", 1), ("Where's a clip?", 1), ("Return what is read.", 0), ("", 0)]
)
def test_docstring_openings(docstring: str, count: int) -> None:
    assert len(indirect_docstrings(list(ast.walk(ast.parse(f'"""{docstring}"""'))))) == count


def test_long_line() -> None:
    assert [finding.line for finding in long_lines(f"{'x' * 120}\n{'x' * 121}")] == [2]
