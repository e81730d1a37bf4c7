"""A stress run's table as the report typesets it."""

import math

import pandas as pd
import pytest
from mlflow import MlflowClient

from supersampling.reporting.pages.stress import sheets, typeset
from supersampling.runs.store import Store

COLUMNS = ["model", "extreme", "precision", "verdict", "why", "value", "truth"]
ROWS = [
    ("tus", "motion/NaN", "float32", "holds", "", None, None),
    ("tus", "motion/NaN", "bfloat16", "holds", "", None, None),
    ("nsrd", "hdr/1e6", "float32", "holds", "", None, None),
    ("nsrd", "hdr/1e6", "float16", "fails", "not finite", None, None),
    ("nsrd", "size/8K input", "float32", "not tried", "needs 900 GB", None, None),
    ("tus", "recovery/state NaN", "float32", "holds", "", 15.0, None),
    ("nsrd", "recovery/state NaN", "float32", "fails", "not finite after 32 frames", None, None),
    ("nsrd", "recovery/color NaN", "float32", "holds", "0.1 away, and nearing", None, None),
    ("reproject=bicubic9", "divergence/static", "float64", "holds", "", 1.0, 1.0),
    ("reproject=bicubic9", "divergence/to and fro 0.5", "float64", "holds", "", 1.0578, 1.0586),
]


@pytest.fixture
def table():
    return pd.DataFrame(ROWS, columns=COLUMNS)


def texts(sheet):
    return {row[0].text: [(cell.text, cell.style) for cell in row[1:]] for row in sheet.rows}


def test_verdicts_are_symbols_with_words(table):
    first, recovery, divergence = typeset(table, "run")
    assert first.headers == ["extreme", "tus", "nsrd"]
    assert texts(first) == {
        "motion/NaN": [("✓ holds", "yes"), ("", "plain")],
        "hdr/1e6": [("", "plain"), ("✗ f16", "no")],
        "size/8K input": [("", "plain"), ("– not tried", "muted")],
    }
    assert first.rules == [1, 2]
    assert texts(recovery) == {
        "color NaN": [("", "plain"), ("✓ finite", "yes")],
        "state NaN": [("✓ 15", "yes"), ("✗ never", "no")],
    }
    assert recovery.headers == ["fault", "tus", "nsrd"]
    (row,) = divergence.rows
    assert [cell.text for cell in row[:4]] == ["bicubic9", "1.0586", "1.0000", "1.0578"]
    assert [cell.style for cell in row[2:4]] == ["plain", "no"]


def test_a_head_is_a_model_s_file_and_its_stages_are_a_note(table):
    wide = table.assign(model=table["model"].replace({"nsrd": "enss_s model.width=16"}))
    first, recovery, _ = typeset(wide, "run")
    assert first.headers == ["extreme", "tus", "enss_s"]
    assert "enss_s: model.width=16." in first.notes
    assert texts(recovery)["state NaN"][1] == ("✗ never", "no")
    two = table.assign(model=table["model"].replace({"nsrd": "tus model.alpha=1"}))
    assert typeset(two, "run")[0].headers == ["extreme", "tus", "tus model.alpha=1"]


def test_a_long_table_goes_on_over_sheets(table):
    many = pd.concat([table.iloc[:1].assign(extreme=f"motion/{k}") for k in range(80)])
    pages = typeset(many, "run")
    assert [len(sheet.rows) for sheet in pages] == [34, 34, 12]
    assert [bool(sheet.notes) for sheet in pages] == [False, False, True]


def test_newest_finished_run_is_reported(table, tmp_path):
    uri = f"sqlite:///{tmp_path}/mlflow.db"
    client = MlflowClient(uri)
    experiment = client.create_experiment("supersampling", (tmp_path / "artifacts").as_uri())
    store = Store(uri, tmp_path / "read")
    assert sheets(store, experiment) == []
    for k, status in enumerate(("FINISHED", "FINISHED", "FAILED")):
        run = client.create_run(experiment, tags={"ss.kind": "stress", "ss.machine": f"machine {k}"}).info.run_id
        stored = table if k != 1 else table.astype(object).where(table.notna(), math.nan).head(5)
        client.log_table(run, stored, "stress.json")
        client.set_terminated(run, status, end_time=1000 + k)
    (only,) = sheets(store, experiment)
    assert "machine 1" in only.notes[-1]
    assert not store.problems


def test_a_run_without_its_table_is_no_sheet(tmp_path):
    uri = f"sqlite:///{tmp_path}/mlflow.db"
    client = MlflowClient(uri)
    experiment = client.create_experiment("supersampling", (tmp_path / "artifacts").as_uri())
    client.set_terminated(client.create_run(experiment, tags={"ss.kind": "stress"}).info.run_id)
    store = Store(uri, tmp_path / "read")
    assert sheets(store, experiment) == []
