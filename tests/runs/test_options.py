"""Identities and checkpoints name options, so that a class can move: its run is found and its checkpoint loads."""

import shutil
from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate

import supersampling.stages.reproject as stage
from supersampling.resources import resources
from supersampling.runs import options as names
from supersampling.runs.checkpoint import build, metadata
from supersampling.runs.experiment import open_experiment
from supersampling.runs.identity import identity
from supersampling.runs.options import Options, described, options, restored

PRINTS = {"train": "a", "val": "b", "test": "c"}
OLD, NEW = "supersampling.stages.reproject.Bicubic9", "supersampling.stages.reproject.NineTaps"


@pytest.fixture
def renamed(tmp_path, monkeypatch):
    """Rename a class, as a developer would: the class, and the files of ``conf/`` that name it."""

    def rename():
        shutil.copytree(resources() / "conf", tmp_path / "conf")
        for path in (tmp_path / "conf").rglob("*.yaml"):
            path.write_text(path.read_text().replace(OLD, NEW))
        monkeypatch.setattr(stage, "NineTaps", stage.Bicubic9, raising=False)
        monkeypatch.delattr(stage, "Bicubic9")
        renamed_options = Options(tmp_path / "conf")
        monkeypatch.setattr(names, "options", lambda: renamed_options)

    return rename


def test_a_renamed_class_keeps_its_run_and_its_checkpoint(entry, renamed, tmp_path):
    cfg = entry("train", "scene=atrium")
    store = open_experiment(f"sqlite:///{tmp_path}/mlflow.db", "test", tmp_path / "artifacts")
    key = identity(cfg, PRINTS, learned=True)
    run = store.start("before", {"ss.identity": key.key}, None)
    torch.manual_seed(0)
    before = instantiate(cfg.model)
    content = metadata(cfg, {}, {}, run)
    renamed()
    cfg.model.reproject._target_ = NEW
    after = identity(cfg, PRINTS, learned=True)
    assert after.key == key.key
    assert store.find(after).info.run_id == run
    model = build(content["model"], "a checkpoint")
    model.load_state_dict(before.state_dict())
    assert type(model.reproject).__name__ == "Bicubic9"  # the class's own name, reached by its new address


def test_a_run_of_the_first_scheme_is_found_after_a_rename(entry, renamed, tmp_path, monkeypatch):
    cfg = entry("train", "scene=atrium")
    store = open_experiment(f"sqlite:///{tmp_path}/mlflow.db", "test", tmp_path / "artifacts")
    former = identity(cfg, PRINTS, learned=True).former
    run = store.start("of the first scheme", {"ss.identity": former}, None)
    renamed()
    monkeypatch.setitem(names.FORMER, OLD, NEW)
    cfg.model.reproject._target_ = NEW
    assert store.find(identity(cfg, PRINTS, learned=True)).info.run_id == run


def test_the_first_scheme_is_what_the_first_version_computed(entry):
    """Computed once by version 0.1.0 at commit a7473c5, for the default job and for a classical one."""
    cfg = entry("train", "scene=atrium", "budget=smoke", "trainer.enable_progress_bar=false", "workers=0")
    assert identity(cfg, PRINTS, learned=True).former == "873ff3b358d57fbf"
    cfg = entry("train", "scene=atrium", "model=tus")
    assert identity(cfg, PRINTS, learned=False).former == "9f4f43223ab80c02"


def test_no_identity_holds_a_class_path(entry):
    for model in ("dlctus", "tus", "nsrr", "nsrd", "enss_m"):
        cfg = entry("train", "scene=atrium", f"model={model}", "loss=nsrd", "augment=full", "optimizer=muon")
        text = str(described({k: v for k, v in _plain(cfg).items() if k not in ("paths", "scene")}))
        assert "supersampling." not in text
        assert "torch." not in text
        assert f"model={model.partition('_')[0]}" in text


def _plain(cfg):
    from omegaconf import OmegaConf

    return OmegaConf.to_container(cfg, resolve=True)


def test_what_is_described_is_restored(entry):
    for model in ("dlctus", "tus", "nsrr_fast", "nsrd", "enss_s"):
        config = _plain(entry("evaluate", f"model={model}").model)
        assert restored(described(config), "a file") == config


def test_every_option_has_a_name_of_its_own():
    listed = dict(options())
    assert len(set(listed.values())) == len(listed)
    for target, name in listed.items():
        assert options().target(name) == target
        assert name.rpartition("=")[2]


# A name that changes gives every run with this class a new identity: all of it would be trained again.
GOLDEN = Path(__file__).with_name("option_names.txt")


def test_the_names_stay():
    missing = set(GOLDEN.read_text().split()) - {name for _, name in options()}
    assert not missing, "these options are not in conf/ any more, or have another name"
