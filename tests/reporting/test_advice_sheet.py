"""The report's page of advice, from runs as advise.py logs them."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from mlflow import MlflowClient

from supersampling.reporting.pages.advice import sheets
from supersampling.runs.store import Store

SUMMARY = {
    "scene": "sundial",
    "space": "nsrd",
    "margin": 0.1,
    "size": "120x68",
    "clips": 4,
    "seeds": 2,
    "chosen": "mask=none previous=1",
    "best": "mask=none previous=2",
    "loss": 0.03,
    "low": -0.02,
    "high": 0.08,
    "ms": 12.34,
    "best_ms": 20.0,
    "unresolved": "a; b",
    "left_out": "motion_dual",
    "left_out_mb": 1.0,
    "of_mb": 9.5,
    "compositions": 16,
    "searched": 8,
    "trainings": 12,
    "steps": 5000,
    "minutes": 8.0,
    "walk_trainings": 32,
    "walk_steps": 48000,
    "walk_minutes": 76.8,
}
PARTS = [
    {
        "part": "previous=2",
        "against": "1",
        "kept": False,
        "round": 1,
        "pairs": 4,
        "db": 0.5,
        "low": 0.4,
        "high": 0.6,
        "ms": 7.0,
    },
    {
        "part": "previous=2",
        "against": "1",
        "kept": False,
        "round": 2,
        "pairs": 1,
        "db": 0.03,
        "low": -0.02,
        "high": 0.08,
        "ms": 7.66,
    },
    {
        "part": "mask=dual",
        "against": "none",
        "kept": False,
        "round": 1,
        "pairs": 0,
        "db": None,
        "low": None,
        "high": None,
        "ms": 0.2,
    },
]
Log = Callable[..., str]


@pytest.fixture
def store(tmp_path: Path) -> tuple[Store, str, Log]:
    client = MlflowClient(f"sqlite:///{tmp_path}/mlflow.db")
    experiment = client.create_experiment("supersampling", (tmp_path / "artifacts").as_uri())

    def log(status: str = "FINISHED", **more: object) -> str:
        row = SUMMARY | more
        tags = {"ss.kind": "advice", "ss.scene": row["scene"], "ss.space": row["space"], "ss.machine": "a machine"}
        run = client.create_run(experiment, tags=tags).info.run_id
        client.log_table(run, pd.DataFrame([row]), "summary.json")
        client.log_table(run, pd.DataFrame(PARTS), "contributions.json")
        client.set_terminated(run, status)
        return run

    return Store(f"sqlite:///{tmp_path}/mlflow.db", tmp_path / "copies"), experiment, log


def texts(sheet) -> list[list[str]]:
    return [[cell.text for cell in row] for row in sheet.rows]


def test_without_advice_there_is_no_page(store: tuple[Store, str, Log]) -> None:
    files, experiment, log = store
    assert sheets(files, experiment) == []
    log(status="FAILED")
    assert sheets(files, experiment) == []


def test_the_newest_of_each_scene_and_space(store: tuple[Store, str, Log]) -> None:
    files, experiment, log = store
    log(loss=9.0)
    log()
    log(scene="bar", unresolved="", left_out="", low=None, high=None)
    answers, saved, parts = sheets(files, experiment)
    assert texts(answers) == [
        ["bar", "nsrd", "mask=none, previous=1", "+0.03", "0.1", "120×68", "12.3", "20.0", "0"],
        ["sundial", "nsrd", "mask=none, previous=1", "+0.03 (−0.02 to +0.08)", "0.1", "120×68", "12.3", "20.0", "2"],
    ]
    assert texts(saved)[1] == [
        "sundial",
        "nsrd",
        "motion_dual",
        "1.00 of 9.50",
        "12 of 32",
        "5 000 of 48 000",
        "8 of 77",
    ]
    assert texts(parts)[0] == ["bar", "previous=2", "1", "+0.03 (−0.02 to +0.08)", "+7.7", "2 (1)", "no"]
    assert texts(parts)[1] == ["", "mask=dual", "none", "not searched", "+0.2", "", "no"]
    assert "a machine" in answers.notes[1]


def test_a_table_that_cannot_be_read_is_a_problem_of_its_run(store: tuple[Store, str, Log], tmp_path: Path) -> None:
    files, experiment, log = store
    run = log()
    next((tmp_path / "artifacts").rglob("summary.json")).write_text("{")
    assert sheets(files, experiment) == []
    assert "cannot be read" in files.problems[run]
