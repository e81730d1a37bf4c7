"""Whole jobs on analytic clips, into an MLflow store of the test's own."""

from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from lightning.pytorch.utilities.rank_zero import rank_zero_only
from mlflow.tracking import MlflowClient
from mlflow.tracking._tracking_service.utils import _get_store
from sqlalchemy import text

from supersampling.commands.train import train
from supersampling.errors import UserError
from supersampling.runs.checkpoint import load_weights
from supersampling.runs.experiment import open_experiment
from supersampling.runs.identity import flat_parameters, identity
from supersampling.training import job
from supersampling.training.fit import fit
from supersampling.training.module import Training

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mlflow")
    return open_experiment(f"sqlite:///{folder}/mlflow.db", "test", folder / "artifacts")


@pytest.fixture
def configure():
    def make(*overrides):
        GlobalHydra.instance().clear()
        with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
            cfg = compose(
                "train",
                ["scene=atrium", "budget=smoke", "workers=0", "trainer.enable_progress_bar=false", *overrides],
                return_hydra_config=True,
            )
        choices = dict(cfg.hydra.runtime.choices)
        cfg = compose_without_hydra(cfg)
        return cfg, choices

    return make


def compose_without_hydra(cfg):
    from omegaconf import open_dict

    with open_dict(cfg):
        del cfg["hydra"]
    return cfg


@pytest.fixture
def files(make_file, tmp_path):
    return {split: [make_file(tmp_path, split)] for split in ("train", "val", "test")}


def test_an_interrupted_training_reaches_the_same_weights(configure, files, store, tmp_path, monkeypatch):
    cfg, _ = configure("budget.epochs=3")
    whole = fit(cfg, files, tmp_path / "whole", store, store.start("whole", {}, None))

    step = Training.training_step

    def failing(self, clip, batch_index):
        if self.global_step == 3:
            raise RuntimeError("power cut")
        return step(self, clip, batch_index)

    run_id = store.start("interrupted", {}, None)
    monkeypatch.setattr(Training, "training_step", failing)
    with pytest.raises(RuntimeError, match="power cut"):
        fit(cfg, files, tmp_path / "cut", store, run_id)
    assert (tmp_path / "cut" / "last.ckpt").exists()  # of the first epoch
    steps = []

    def counting(self, clip, batch_index):
        steps.append(self.global_step)
        return step(self, clip, batch_index)

    monkeypatch.setattr(Training, "training_step", counting)
    resumed = fit(cfg, files, tmp_path / "cut", store, run_id)
    assert steps[0] == cfg.budget.steps  # goes on behind it
    for name, weight in whole.state_dict().items():
        assert torch.equal(weight, resumed.state_dict()[name]), name


def test_training_changes_the_weights_and_lowers_the_loss(configure, files, store, tmp_path, monkeypatch):
    monkeypatch.setattr(rank_zero_only, "rank", 1)  # as SLURM_PROCID=1 sets it; the only process logs all the same
    cfg, _ = configure("budget.epochs=3", "budget.steps=40", "loss.theta=0", "augment=none")
    run_id = store.start("learn", {}, None)
    fit(cfg, files, tmp_path / "learn", store, run_id)
    losses = [m.value for m in store.client.get_metric_history(run_id, "train/loss")]
    assert len(losses) == 3
    assert losses[-1] < 0.9 * losses[0]


def test_a_checkpoint_of_another_model_says_so(configure, files, store, tmp_path):
    from hydra.utils import instantiate

    cfg, _ = configure("budget.epochs=1")
    fit(cfg, files, tmp_path / "a", store, store.start("a", {}, None))
    other, _ = configure("model/accumulate=none")
    with pytest.raises(UserError, match="does not hold weights of the configured model"):
        load_weights(instantiate(other.model), tmp_path / "a" / "last.ckpt")
    with pytest.raises(UserError, match="There is no checkpoint"):
        load_weights(instantiate(other.model), tmp_path / "nothing.ckpt")


def test_identity_knows_what_changes_a_result(configure):
    prints = {"train": "a", "val": "b", "test": "c"}

    def of(*overrides, learned=True, data=prints):
        return identity(configure(*overrides)[0], data, learned)

    base = of()
    assert base == of("workers=1", "paths.root=/elsewhere", "trainer.enable_progress_bar=true", "scene=foundry")
    different = [
        of("seed=1"),
        of("loss.theta=0.2"),
        of("model/reproject=bilinear"),
        of("model.reproject.a=-0.5"),
        of("budget.lr=0.002"),
        of("trainer.precision=bf16-mixed"),
        of(data={**prints, "train": "z"}),
    ]
    assert len({base, *different}) == 1 + len(different)
    classical = of("model=tus", learned=False)
    assert classical == of("model=tus", "seed=5", "loss=l1", "budget.lr=0.1", learned=False)
    assert classical != of("model=tus", "model/rectify=none", learned=False)


def test_parameters_are_flat_and_readable(configure):
    cfg, choices = configure("loss.theta=0.5", "model/accumulate=none")
    flat = flat_parameters(cfg, choices, learned=True)
    expected = {
        "model": "dlctus", "model.accumulate": "none", "model.reproject": "bicubic9", "model.reproject.a": -0.75,
        "loss": "spatiotemporal", "loss.theta": 0.5, "task.scale": 4, "task.mip_bias": "matched", "seed": 0,
        "budget": "smoke", "budget.epochs": 2, "data": "laptop", "data.scenes": "atrium",
    }  # fmt: skip
    assert {k: flat.get(k) for k in expected} == expected
    assert not [k for k in flat if "_target_" in k or k.startswith("paths")]


def test_an_unreachable_server_says_so(tmp_path):
    with pytest.raises(UserError, match=r"No MLflow server answers at .*127.0.0.1:9"):
        open_experiment("http://127.0.0.1:9", "test", tmp_path)


def test_a_finished_run_is_preferred_to_a_newer_unfinished_one(store):
    client: MlflowClient = store.client
    first = store.start("first", {"ss.identity": "abc"}, None)
    store.finish(first)
    store.start("second", {"ss.identity": "abc"}, None)
    assert store.find("abc").info.run_id == first
    assert store.find("never") is None
    assert client.get_run(first).data.tags["ss.machine"]


def test_an_interrupt_in_the_middle_of_a_transaction_is_noted(entry, files, tmp_path, monkeypatch):
    """The store's lock is held by what was cut short, and given back before the run is ended."""
    uri = f"sqlite:///{tmp_path}/mlflow.db"

    def interrupted(*arguments, **more):
        session = _get_store(uri).ManagedSessionMaker().__enter__()
        session.execute(text("UPDATE runs SET name = 'half'"))
        raise KeyboardInterrupt

    monkeypatch.setattr(job, "evaluate", interrupted)
    data = [f"data.{split}=[{paths[0]}]" for split, paths in files.items()]
    small = ["data=files", "scene=atrium", "model=bicubic", "baselines=[]", "metrics=fast", "threads=1"]
    with pytest.raises(KeyboardInterrupt):
        train(entry("train", *small, *data, f"paths.root={tmp_path}", f"tracking_uri={uri}"))
    client = MlflowClient(uri)
    known = client.get_experiment_by_name("supersampling").experiment_id
    (run,) = client.search_runs([known], "tags.`ss.kind` = 'job'")
    assert (run.info.status, run.info.run_name) == ("KILLED", "bicubic x4")
