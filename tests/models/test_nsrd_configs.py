"""Every configuration of NSRD composes and takes a training step; its recipe is the paper's."""

from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate

from supersampling.commands.resolvers import register
from supersampling.frames import Frame
from supersampling.training.module import unroll

CONF = Path(__file__).resolve().parents[2] / "conf"
OPTIONS = [
    f"model/{slot}={option.stem}"
    for slot in ("demodulate", "motion_mask", "recur", "locate", "base")
    for option in sorted((CONF / "model" / slot).glob("*.yaml"))
]
SIZES = {
    "color": 3,
    "radiance": 3,
    "material": 3,
    "emission": 3,
    "depth": 1,
    "normal": 3,
    "motion": 2,
    "motion_dual": 2,
}
HIGH = ("target", "target_radiance", "high_material", "high_emission")


def composed(*overrides):
    register()
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose("train", ["scene=atrium", "model=nsrd", "loss=nsrd", *overrides])


def clip(scale, frames, b=2, h=8, w=9):
    torch.manual_seed(0)
    buffers = {name: torch.rand(b, frames, c, h, w) for name, c in SIZES.items()}
    buffers["motion"] = (buffers["motion"] - 0.5) * 0.1
    buffers["jitter"] = torch.rand(b, frames, 2) - 0.5
    buffers["motion_dual"] = buffers["motion"] + (torch.rand(b, frames, 1, h, w) > 0.8) * 0.05
    return buffers | {name: torch.rand(b, frames, 3, h * scale, w * scale) for name in HIGH}


@pytest.mark.parametrize("overrides", [(o,) for o in OPTIONS] + [(f"task.scale={s}",) for s in (2, 4, 6)])
def test_a_training_step_changes_every_weight(overrides):
    cfg = composed(*(("task.scale=2",) if "scale" not in overrides[0] else ()), *overrides)
    model, loss = instantiate(cfg.model), instantiate(cfg.loss)
    buffers = clip(model.scale, 3)
    inputs = {k: v for k, v in buffers.items() if k in model.requires | model.compares | loss.requires}
    before = [p.detach().clone() for p in model.parameters()]
    optimizer = torch.optim.Adam(model.parameters(), lr=1e-3)
    value = loss(unroll(model, inputs, 3), model.reference(inputs), inputs)
    value.backward()
    optimizer.step()
    assert value.isfinite()
    for old, (name, new) in zip(before, model.named_parameters(), strict=True):
        # All 4 units inside an attention may be below 0 for every image, at the published width.
        assert "attention" in name or not torch.equal(old, new), name
    for t in range(3):
        image = model.present(torch.randn(2, 3, 8 * model.scale, 9 * model.scale), Frame.from_clip(inputs, t))
        assert image.min() >= 0.0
        assert image.max() <= 1.0


def test_recipe_of_paper():
    """Section 4.1, transcribed independently."""
    cfg = composed("experiment=nsrd")
    assert cfg.model._target_.endswith("NSRD")
    assert (cfg.task.scale, cfg.budget.crop // cfg.task.scale, cfg.budget.batch) == (4, 96, 8)
    assert (cfg.budget.epochs, cfg.optimizer.lr, cfg.model.previous) == (200, 5e-4, 2)
    assert 5000 <= cfg.budget.steps * cfg.budget.batch <= 5200
    assert (cfg.data.train.clips, cfg.data.val.clips, cfg.data.test.clips) == (54, 6, 12)
    assert cfg.data.train.frames == 100
    assert cfg.optimizer._target_ == "torch.optim.Adam"
    # The rate is halved every 100 epochs.
    cfg.budget.steps = 2
    optimizer = instantiate(cfg.optimizer)([torch.zeros(1, requires_grad=True)])
    scheduler, rates = instantiate(cfg.budget.scheduler)(optimizer), []
    for _ in range(2 * cfg.budget.epochs):
        rates.append(optimizer.param_groups[0]["lr"])
        optimizer.step()
        scheduler.step()
    assert rates == [5e-4] * 200 + [2.5e-4] * 200


def test_the_recipe_runs_on_another_budget():
    cfg = composed("experiment=nsrd", "budget=laptop")
    assert (cfg.budget.epochs, cfg.loss._target_) == (composed("budget=laptop").budget.epochs, composed().loss._target_)
    assert cfg.data.train.clips == 54
