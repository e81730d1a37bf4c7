"""Every experiment, sweep, budget and data preset composes, and what they name exists."""

from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from omegaconf import OmegaConf

from supersampling.commands.train import baselines
from supersampling.runs.naming import method_name

ROOT = Path(__file__).resolve().parents[2]


def stems(folder: str) -> list[str]:
    return sorted(p.stem for p in (ROOT / folder).glob("*.yaml"))


def composed(*overrides: str):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        return compose("train", ["scene=atrium", *overrides], return_hydra_config=True)


CASES = [
    *(f"experiment={n}" for n in stems("conf/experiment")),
    *(f"experiment=laptop/{n}" for n in stems("conf/experiment/laptop")),
    *(f"budget={n}" for n in stems("conf/budget")),
    *(f"data={n}" for n in stems("conf/data")),
    *(f"debug={n}" for n in stems("conf/debug")),
    *(f"sweeps={n}" for n in stems("sweeps")),
]


@pytest.mark.parametrize("override", CASES)
def test_it_composes_and_its_model_and_loss_are_made(override, vgg):
    cfg = composed(override)
    OmegaConf.resolve(cfg.model)
    model = instantiate(cfg.model)
    assert model.scale == cfg.task.scale
    instantiate(cfg.loss)
    instantiate(cfg.optimizer)
    instantiate(cfg.budget.scheduler)


def test_the_thesis_recipe_is_the_thesis_s():
    """Sections 4.2.2, 4.3.1: the numbers typed a second time."""
    cfg = composed("experiment=dlctus")
    assert (cfg.budget.crop, cfg.budget.batch, cfg.budget.frames, cfg.budget.counted) == (256, 4, 30, 5)
    assert (cfg.budget.epochs, cfg.optimizer.lr) == (200, 1e-4)
    assert [cfg.data[s].clips for s in ("train", "val", "test")] == [80, 10, 10]
    assert cfg.data.train.frames == 60
    assert cfg.data.train.samples**2 == 64


@pytest.mark.parametrize("override", [c for c in CASES if c.startswith(("experiment", "sweeps"))])
def test_itsbaselines_are_the_same_job_with_another_method(override):
    cfg = composed(override, "task.scale=3", "loss=l1")
    HydraConfig.instance().set_config(cfg)
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        jobs = baselines(cfg)
    assert [method_name(choices) for _, choices in jobs] == ["bicubic", "jau", "tus_thesis", "tus", "tus rectify=none"]
    for job, _ in jobs:
        assert instantiate(job.model).scale == 3
        kept = [OmegaConf.to_yaml(c[key], resolve=True) for c in (job, cfg) for key in ("task", "data")]
        assert kept[:2] == kept[2:]
    assert [bool(OmegaConf.select(job, "tune.grid")) for job, _ in jobs] == [False, False, False, True, True]
