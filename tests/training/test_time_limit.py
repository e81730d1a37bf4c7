"""Trainings that stop amid their work, by ``trainer.max_time`` or otherwise, and continue to the same weights."""

from itertools import count

import pytest
import torch

from supersampling.errors import TimeLimitReached
from supersampling.runs.experiment import open_experiment
from supersampling.training.fit import fit
from supersampling.training.module import Training

SMALL = ("scene=atrium", "budget=smoke", "budget.steps=3", "trainer.enable_progress_bar=false", "optimizer=muon")


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mlflow")
    return open_experiment(f"sqlite:///{folder}/mlflow.db", "test", folder / "artifacts")


@pytest.fixture
def files(make_file, tmp_path):
    return {split: [make_file(tmp_path, split)] for split in ("train", "val", "test")}


@pytest.fixture
def batches(monkeypatch):
    """The epoch and the number of every batch that is trained on."""
    values = []
    step = Training.training_step

    def recorded(self, clip, batch_index):
        values.append((self.current_epoch, batch_index))
        return step(self, clip, batch_index)

    monkeypatch.setattr(Training, "training_step", recorded)
    return values


@pytest.mark.parametrize(
    ("workers", "settings", "stops"),
    [(0, [], 5), (1, ["++trainer.accumulate_grad_batches=2", "++trainer.val_check_interval=1"], 3)],
)
def test_a_training_that_stops_after_every_step(
    workers, settings, stops, entry, files, store, tmp_path, monkeypatch, batches
):
    cfg = entry("train", *SMALL, f"workers={workers}", *settings)
    whole = fit(cfg, files, tmp_path / "whole", store, store.start("whole", {}, None))
    expected = batches.copy()
    batches.clear()
    clock = count(step=2)
    monkeypatch.setattr("supersampling.training.time_limit.monotonic", lambda: next(clock))
    limited = entry("train", *SMALL, f"workers={workers}", *settings, "++trainer.max_time={seconds:1}")
    run = store.start("cut", {}, None)
    for number in range(1, stops + 1):
        with pytest.raises(TimeLimitReached, match=f"after {number} of {stops + 1} steps"):
            fit(limited, files, tmp_path / "cut", store, run)
    cut = fit(limited, files, tmp_path / "cut", store, run)
    assert batches == expected
    for name, weight in whole.state_dict().items():
        assert torch.equal(weight, cut.state_dict()[name]), name


def test_workers_read_the_windows_of_the_epoch_that_continues(entry, files, store, tmp_path, monkeypatch):
    """They read ahead, before Lightning sets the epoch."""
    cfg = entry("train", *SMALL, "workers=1")
    whole = fit(cfg, files, tmp_path / "whole", store, store.start("whole", {}, None))
    step = Training.training_step

    def failing(self, clip, batch_index):
        if self.global_step == 4:
            raise RuntimeError("power cut")
        return step(self, clip, batch_index)

    run = store.start("cut", {}, None)
    monkeypatch.setattr(Training, "training_step", failing)
    with pytest.raises(RuntimeError, match="power cut"):
        fit(cfg, files, tmp_path / "cut", store, run)
    monkeypatch.setattr(Training, "training_step", step)
    cut = fit(cfg, files, tmp_path / "cut", store, run)
    for name, weight in whole.state_dict().items():
        assert torch.equal(weight, cut.state_dict()[name]), name
