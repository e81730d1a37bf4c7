"""What backends and precisions change in a trained run's quality, by the command; and the backend that has one method alone."""

import shutil

import numpy as np
import pytest
import torch
from mlflow.tracking import MlflowClient

from supersampling.commands.benchmark import benchmark
from supersampling.commands.cost import cost
from supersampling.commands.train import train
from supersampling.errors import UserError
from supersampling.models.bicubic import Bicubic
from supersampling.profiling.backends import ChannelsLast, Eager, Setting
from supersampling.profiling.native import Native
from supersampling.runs.experiment import experiment_of


@pytest.fixture
def trained(make_file, entry, tmp_path):
    """Settings of a store with one trained run, and the run's id."""
    files = [f"data.{s}=[{make_file(tmp_path, s, frames=6)}]" for s in ("train", "val", "test")]
    tracking = f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"
    settings = ["data=files", "scene=atrium", "threads=1", f"paths.root={tmp_path}", tracking, *files]
    train(entry("train", *settings, "model=dlctus", "budget=smoke", "baselines=[]", "metrics=fast"))
    client = MlflowClient(f"sqlite:///{tmp_path}/mlflow.db")
    known = client.get_experiment_by_name("supersampling").experiment_id
    (run,) = client.search_runs([known], "tags.`ss.kind` = 'job'")
    return settings, run


@pytest.mark.slow
def test_what_bfloat16_changes_is_taken_against_the_trained_weights(trained, entry):
    settings, run = trained
    cfg = entry("benchmark", *settings, f"run={run.info.run_id}", "precisions=[float32,bfloat16]", "cost=true")
    table = cost(cfg, experiment_of(cfg), {"eager": Eager(), "channels_last": ChannelsLast()})
    said = {*zip(table.backend, table.precision)}
    assert said == {("eager", "bfloat16"), ("channels_last", "float32"), ("channels_last", "bfloat16")}
    assert set(table.run) == {run.info.run_id}
    exact = table[table.precision == "float32"]
    assert np.allclose(exact.changed, exact.psnr, atol=1e-3)
    assert len(exact) == 6  # frames of the first clip
    changed = table[table.precision == "bfloat16"]
    assert (changed.changed - changed.psnr).abs().max() > 1e-5
    assert (changed.changed - changed.psnr).abs().max() < 1.0


def test_cost_without_weights_is_refused(entry, tmp_path):
    with pytest.raises(UserError, match="cost=true needs trained weights"):
        benchmark(entry("benchmark", f"paths.root={tmp_path}", "cost=true", "threads=1"))


def test_native_has_one_method_on_one_device():
    cpu = torch.device("cpu")
    with pytest.raises(UserError, match="DLCTUS alone, not Bicubic"):
        Native().load(Bicubic(4), Setting(8, 6, "float32", cpu, 1))
    assert "float32 alone" in Native().missing(cpu, "bfloat16")
    assert "cuda" in Native().missing(torch.device("cuda"), "float32")


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")
def test_native_gives_dlctus_s_images(entry):
    from hydra.utils import instantiate

    from supersampling.deploy.check import random_frames

    model = instantiate(entry("benchmark", "model=dlctus").model).eval()
    setting = Setting(16, 12, "float32", torch.device("cpu"), 1)
    native, eager = (backend.load(model, setting) for backend in (Native(), Eager()))
    assert native.model is None  # it has no parts
    for frame in random_frames(model, (16, 12), 5, None):
        ours, theirs = (stream.image(stream.step(stream.prepare(frame))) for stream in (native, eager))
        assert (ours - theirs).abs().max() < 2e-4
