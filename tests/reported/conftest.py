"""Faults that people reported of other projects, tried on this one: what a user gets, row by row.

``python -m pytest tests/reported`` runs them and prints the table.
"""

from collections.abc import Callable
from pathlib import Path

import pytest
from capture_files import make_source

ROW = "reported row"


@pytest.fixture
def row(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Return a function that puts a row into the table: ``row("17", "EXR with several layers", "refused: ...")``."""

    def add(number: str, report: str, answer: str) -> None:
        request.node.user_properties.append((ROW, (number, report, answer)))

    return add


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print what a user gets for each reported fault."""
    rows = {
        value
        for kind, state in (("passed", ""), ("failed", "FAILS: "))
        for report in terminalreporter.stats.get(kind, [])
        for name, (number, title, answer) in (p for p in report.user_properties if p[0] == ROW)
        for value in [(number, title, state + answer)]
    }
    for number, title, answer in sorted(rows, key=lambda r: (int("".join(filter(str.isdigit, r[0])) or 0), r)):
        terminalreporter.write_line(f"{number:>4}  {title}\n      {answer}")


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return small data set files of the closed-form world by split; they are read only."""
    folder = tmp_path_factory.mktemp("world")
    return {split: make_source(folder / split, split=split) for split in ("train", "val", "test")}


@pytest.fixture
def data(files: dict[str, Path], tmp_path: Path) -> list[str]:
    """Return the overrides of ``train.py`` for a smoke training on these files, in a project of its own."""
    splits = [f"data.{split}=[{path}]" for split, path in files.items()]
    return [
        *("data=files", *splits, "scene=atrium", "task.scale=2", "budget=smoke", "metrics=fast", "baselines=[]"),
        *("workers=0", "threads=1", "trainer.accelerator=cpu", "trainer.enable_progress_bar=false"),
        f"paths.root={tmp_path}",
    ]


@pytest.fixture
def scoring(files: dict[str, Path], tmp_path: Path) -> list[str]:
    """Return the overrides of ``evaluate.py`` that score JAU on the world's test file."""
    test = f"data.test=[{files['test']}]"
    return [
        *("data=files", test, "scene=atrium", "task.scale=2", "metrics=fast", "model=jau", "threads=1"),
        f"paths.root={tmp_path}",
    ]
