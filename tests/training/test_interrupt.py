"""``train.py`` as a process that is stopped, in a folder of its own."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch
from mlflow.tracking import MlflowClient

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 600  # until a process counts as hung


def begin(root, files, *sweep):
    data = [f"data.{split}=[{path}]" for split, path in files.items()]
    settings = [
        "data=files",
        "metrics=fast",
        *data,
        "scene=atrium",
        "baselines=[]",
        "budget=smoke",
        "budget.epochs=8",
        "budget.steps=8",
        "threads=1",
        "workers=0",
        "trainer.enable_progress_bar=false",
        f"paths.root={root}",
    ]
    command = [sys.executable, "train.py", "-m", *settings, *(sweep or ("model=dlctus", "loss.theta=0.1,0.5"))]
    environment = {**os.environ, "MLFLOW_TRACKING_URI": f"sqlite:///{root}/mlflow.db"}
    return subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE, text=True)


def checkpoints(root):
    return sorted((root / "outputs" / "checkpoints").glob("*/last.ckpt"))


def weights(root):
    return [torch.load(path, weights_only=True)["state_dict"] for path in checkpoints(root)]


def statuses(root, kind):
    client = MlflowClient(f"sqlite:///{root}/mlflow.db")
    runs = client.search_runs([e.experiment_id for e in client.search_experiments()], f"tags.`ss.kind` = '{kind}'")
    return sorted(run.info.status for run in runs)


def scores(root):
    """Every test value of every job, by the job's name."""
    client = MlflowClient(f"sqlite:///{root}/mlflow.db")
    runs = client.search_runs([e.experiment_id for e in client.search_experiments()], "tags.`ss.kind` = 'job'")
    return {run.info.run_name: {k: v for k, v in run.data.metrics.items() if k.startswith("test/")} for run in runs}


@pytest.fixture(scope="module")
def files(make_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    return {split: make_file(folder, split) for split in ("train", "val", "test")}


@pytest.fixture(scope="module")
def whole(files, tmp_path_factory):
    root = tmp_path_factory.mktemp("whole")
    assert begin(root, files).wait(SECONDS) == 0
    return root


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_stopped_sweep_stops_and_goes_on_to_the_same_weights(how, files, whole, tmp_path):
    cut = tmp_path
    process = begin(cut, files)
    deadline = time.monotonic() + SECONDS
    while not checkpoints(cut) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(how)
    _, said = process.communicate(timeout=SECONDS)
    assert len(checkpoints(cut)) == 1  # it did not go on to the next job
    if how == signal.SIGTERM:
        assert process.returncode == 130
        assert "continues from here" in said
        assert statuses(cut, "job") == ["KILLED"]
        assert statuses(cut, "sweep") == ["KILLED"]

    assert begin(cut, files).wait(SECONDS) == 0
    assert statuses(cut, "job") == ["FINISHED", "FINISHED"]
    for ours, theirs in zip(weights(cut), weights(whole), strict=True):
        assert all(torch.equal(ours[name], theirs[name]) for name in theirs)


def test_a_failed_job_stops_no_other(files, tmp_path):
    """The first needs larger images than there are; the second is trained, and the exit status tells of the first."""
    process = begin(tmp_path, files, "model=dlctus", "budget.crop=512,32")
    _, said = process.communicate(timeout=SECONDS)
    assert process.returncode == 2
    assert "budget.crop=512" in said
    assert "1 of the jobs failed" in said
    assert "Traceback" not in said
    assert statuses(tmp_path, "job").count("FINISHED") == 1
    assert statuses(tmp_path, "sweep") == ["FAILED"]


@pytest.mark.slow
def test_a_sweep_killed_at_ten_random_moments_ends_as_if_it_had_not_been(files, whole, tmp_path):
    moments = np.random.default_rng(0).uniform(0.0, 14.0, 10)
    for seconds in moments:
        process = begin(tmp_path, files)
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    assert begin(tmp_path, files).wait(SECONDS) == 0
    assert statuses(tmp_path, "job") == ["FINISHED", "FINISHED"]  # no job has two runs
    for ours, theirs in zip(weights(tmp_path), weights(whole), strict=True):
        assert all(torch.equal(ours[name], theirs[name]) for name in theirs)
    assert scores(tmp_path) == scores(whole)
