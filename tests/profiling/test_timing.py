"""Table of timings, and fingerprints of architectures."""

import math
from dataclasses import replace

import pytest
from mlflow.tracking import MlflowClient

from supersampling.runs.timing import Timing, architecture, read, table

TIMED = Timing(
    method="dlctus",
    architecture="0123456789abcdef",
    scale=4,
    width=1920,
    height=1080,
    backend="eager",
    precision="float32",
    device="cpu",
    threads=2,
    machine="a machine",
    ms=12.5,
    low=12.0,
    high=13.25,
    frames=100,
    peak_mb=480.0,
    parameters=78_112,
    gmac=10.086,
    gbytes=0.0947,
    of_product=0.5,
    of_copy=0.25,
)
_UNKNOWN = dict.fromkeys(("ms", "low", "high", "peak_mb", "gmac", "of_product", "of_copy"), math.nan)
MISSING = replace(TIMED, backend="tensorrt", frames=0, reason="TensorRT needs an NVIDIA GPU.", **_UNKNOWN)
DIGITS = replace(TIMED, architecture="0123456789012345", method="1e5")


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("store")
    client = MlflowClient(f"sqlite:///{folder}/mlflow.db")
    return client, client.create_experiment("e", artifact_location=(folder / "artifacts").as_uri()), folder


@pytest.mark.parametrize("rows", [[TIMED, MISSING], [MISSING], [TIMED], [DIGITS, replace(MISSING, ms=0.0)]])
def test_timings_come_back_from_mlflow(store, rows):
    client, experiment, folder = store
    run_id = client.create_run(experiment).info.run_id
    client.log_table(run_id, table(rows), "timings.json")
    timings = read(folder / "artifacts" / run_id / "artifacts" / "timings.json")
    assert list(map(repr, timings)) == list(map(repr, rows))  # NaN is not equal to itself
    assert [t.runs for t in timings] == [math.isfinite(t.ms) for t in rows]


def test_stored_columns():
    """The column of a missing time's reason keeps the name that it has in stored tables."""
    assert list(table([MISSING]).columns)[-2:] == ["of_copy", "why"]


def test_architecture_is_what_decides_speed():
    model = {"_target_": "a.B", "scale": 4, "pad": {"_target_": "a.C", "n": 1}, "initialise": {"_target_": "a.D"}}
    key = architecture(model, 4)
    assert len(key) == 16
    assert set(key) <= set("0123456789abcdef")
    assert architecture(dict(reversed(model.items())), 4) == key
    assert architecture({**model, "initialise": {"_target_": "a.E"}}, 4) == key
    different = [architecture(model, 2), architecture({**model, "pad": {"_target_": "a.C", "n": 2}}, 4)]
    assert len({key, *different}) == 3
