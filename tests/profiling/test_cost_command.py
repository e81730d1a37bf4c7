"""Effect of backends and precisions on a trained run's quality, by the command; the backend for one method only."""

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
from supersampling.profiling.backends import ChannelsLast, Eager, LoadOptions
from supersampling.profiling.native import Native
from supersampling.runs.experiment import experiment_of


@pytest.fixture
def trained(make_file, entry, tmp_path):
    """Return the settings of a store with one trained run, and the run."""
    files = [f"data.{s}=[{make_file(tmp_path, s, frames=6)}]" for s in ("train", "val", "test")]
    tracking = f"tracking_uri=sqlite:///{tmp_path}/mlflow.db"
    settings = ["data=files", "scene=atrium", "threads=1", f"paths.root={tmp_path}", tracking, *files]
    train(entry("train", *settings, "model=dlctus", "budget=smoke", "baselines=[]", "metrics=fast"))
    client = MlflowClient(f"sqlite:///{tmp_path}/mlflow.db")
    known = client.get_experiment_by_name("supersampling").experiment_id
    (run,) = client.search_runs([known], "tags.`ss.kind` = 'job'")
    return settings, run


@pytest.mark.slow
def test_effect_of_bfloat16_on_the_trained_weights(trained, entry):
    settings, run = trained
    cfg = entry("benchmark", *settings, f"run={run.info.run_id}", "precisions=[float32,bfloat16]", "cost=true")
    table = cost(cfg, experiment_of(cfg), {"eager": Eager(), "channels_last": ChannelsLast()})
    variants = {*zip(table.backend, table.precision)}
    assert variants == {("eager", "bfloat16"), ("channels_last", "float32"), ("channels_last", "bfloat16")}
    assert set(table.run) == {run.info.run_id}
    exact = table[table.precision == "float32"]
    assert np.allclose(exact.changed, exact.psnr, atol=1e-3)
    assert len(exact) == 6  # frames of the first clip
    changed = table[table.precision == "bfloat16"]
    assert (changed.changed - changed.psnr).abs().max() > 1e-5
    assert (changed.changed - changed.psnr).abs().max() < 1.0


def test_cost_without_weights_is_an_error(entry, tmp_path):
    with pytest.raises(UserError, match="cost=true needs trained weights"):
        benchmark(entry("benchmark", f"paths.root={tmp_path}", "cost=true", "threads=1"))


def options(width, height):
    return LoadOptions(width=width, height=height, precision="float32", device=torch.device("cpu"), threads=1)


def test_native_runs_one_method_on_one_device():
    with pytest.raises(UserError, match="DLCTUS only, not Bicubic"):
        Native().load(Bicubic(4), options(8, 6))
    assert "float32 only" in Native().missing(torch.device("cpu"), "bfloat16")
    assert "cuda" in Native().missing(torch.device("cuda"), "float32")


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")
def test_native_gives_the_images_of_dlctus(entry):
    from hydra.utils import instantiate

    from supersampling.deploy.check import random_frames

    model = instantiate(entry("benchmark", "model=dlctus").model).eval()
    native, eager = (backend.load(model, options(16, 12)) for backend in (Native(), Eager()))
    assert native.model is None  # it has no parts
    for frame in random_frames(model, (16, 12), 5, None):
        image, expected = (stream.image(stream.step(stream.prepare(frame))) for stream in (native, eager))
        assert (image - expected).abs().max() < 2e-4
