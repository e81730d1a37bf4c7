"""Timings' table, and what an architecture is."""

import math
from dataclasses import replace

import pytest
from mlflow.tracking import MlflowClient

from supersampling.runs.timing import Timing, architecture, read, table

ONE = Timing(
    "dlctus", "0123456789abcdef", 4, 1920, 1080, "eager", "float32", "cpu", 2, "a machine", 12.5, 12.0, 13.25, 100, 480.0,
    78_112, 10.086, 0.0947, 0.5, 0.25,
)  # fmt: skip
NONE = replace(
    ONE, backend="tensorrt", ms=math.nan, low=math.nan, high=math.nan, frames=0, peak_mb=math.nan,
    gmac=math.nan, of_product=math.nan, of_copy=math.nan, why="TensorRT needs an NVIDIA GPU.",
)  # fmt: skip


DIGITS = replace(ONE, architecture="0123456789012345", method="1e5")


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("store")
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    return client, client.create_experiment("e", artifact_location=(folder / "artifacts").as_uri()), folder


@pytest.mark.parametrize("rows", [[ONE, NONE], [NONE], [ONE], [DIGITS, replace(NONE, ms=0.0)]])
def test_it_comes_back_from_mlflow(store, rows):
    client, experiment, folder = store
    run_id = client.create_run(experiment).info.run_id
    client.log_table(run_id, table(rows), "timings.json")
    found = read(folder / "artifacts" / run_id / "artifacts" / "timings.json")
    assert list(map(repr, found)) == list(map(repr, rows))  # NaN is not equal to itself
    assert [t.runs for t in found] == [math.isfinite(t.ms) for t in rows]


def test_an_architecture_is_what_decides_speed():
    model = {
        "_target_": "a.B",
        "scale": 4,
        "pad": {"_target_": "a.C", "n": 1},
        "initialise": {"_target_": "a.D"},
    }
    key = architecture(model, 4)
    assert len(key) == 16
    assert set(key) <= set("0123456789abcdef")
    assert architecture(dict(reversed(model.items())), 4) == key
    assert architecture({**model, "initialise": {"_target_": "a.E"}}, 4) == key
    others = [architecture(model, 2), architecture({**model, "pad": {"_target_": "a.C", "n": 2}}, 4)]
    assert len({key, *others}) == 3
