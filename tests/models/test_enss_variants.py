"""Every option of every stage of ENSS from the command line, and the recipe."""

from functools import cache, partial
from pathlib import Path

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from supersampling.losses import L1
from supersampling.training.module import Training, unroll

CONF = Path(__file__).parents[2] / "conf"
SLOTS = ("flow", "motion_grid", "reproject", "history", "kernel_prediction", "confine")
VARIANTS = [f"model/{slot}={p.stem}" for slot in SLOTS for p in sorted((CONF / "model" / slot).glob("*.yaml"))]

pytestmark = pytest.mark.usefixtures("raft")


@cache
def configured(*overrides):
    with initialize_config_dir(str(CONF), version_base="1.3"):
        return compose("train", ["scene=atrium", *overrides])


def small(override, scale):
    """Return ENSS S with a narrow MLP, and with RAFT of a single update."""
    config = configured("model=enss_s", override)
    config.task.scale = scale
    if "width" in config.model.kernel_prediction:
        config.model.kernel_prediction.width = 16
    if "updates" in config.model.flow:
        config.model.flow.updates = 1
    torch.manual_seed(0)
    return instantiate(config.model)


def clip(frames=3, b=2, h=5, w=6):
    g = torch.Generator().manual_seed(0)
    return {
        "color": torch.rand(b, frames, 3, h, w, generator=g),
        "depth": torch.rand(b, frames, 1, h, w, generator=g),
        "motion": torch.randn(b, frames, 2, h, w, generator=g) * 0.1,
        "jitter": torch.rand(b, frames, 2, generator=g) - 0.5,
    }


@pytest.mark.parametrize("override", VARIANTS)
def test_every_variant_composes_and_trains(override):
    model, buffers = small(override, 2), clip()
    buffers_of_model = {name: buffers[name] for name in model.requires}
    buffers_of_model["color"].requires_grad_()
    batch = buffers_of_model | {"target": torch.rand(2, 3, 3, 10, 12)}
    adam = partial(torch.optim.Adam, lr=1e-3)
    training = Training(model, L1(), adam, partial(torch.optim.lr_scheduler.ConstantLR, factor=1.0), counted=1)
    training.log = lambda *args, **kwargs: None
    optimizer = adam(model.parameters())
    value = training.training_step(batch, 0)
    value.backward()
    before = [p.detach().clone() for p in model.parameters()]
    for parameter in model.parameters():
        assert parameter.grad is not None
        assert parameter.grad.isfinite().all()
    reached = buffers_of_model["color"].grad[:, 0].abs().max() > 0
    assert reached == ("history=none" not in override)
    optimizer.step()
    assert any(not torch.equal(a, b) for a, b in zip(before, model.parameters()))


@pytest.mark.parametrize("override", VARIANTS)
@pytest.mark.parametrize(("scale", "h", "w"), [(2, 5, 6), (3, 1, 1), (4, 3, 7), (5, 2, 1), (6, 4, 5)])
def test_any_size_in_range_and_items_do_not_mix(override, scale, h, w):
    model, buffers = small(override, scale), clip(h=h, w=w)
    with torch.no_grad():
        outputs = unroll(model, buffers, 3)
        alone = unroll(model, {name: buffer[1:] for name, buffer in buffers.items()}, 3)
    assert outputs.shape == (2, 3, 3, h * scale, w * scale)
    assert outputs.min() >= 0.0
    assert outputs.max() <= 1.0
    torch.testing.assert_close(alone[0], outputs[1], rtol=0, atol=1e-5)


def test_recipe_of_paper():
    """Section 5, transcribed independently."""
    cfg, laptop = configured("experiment=enss"), configured("experiment=enss", "budget=laptop")
    assert (cfg.budget.batch, cfg.budget.frames, cfg.budget.crop) == (8, 16, 264)
    assert cfg.budget.epochs * cfg.budget.steps == 500_000
    optimizer = instantiate(cfg.optimizer)([torch.nn.Parameter(torch.zeros(1))])
    assert isinstance(optimizer, torch.optim.Adam)
    assert optimizer.param_groups[0]["lr"] == 1e-4
    scheduler = instantiate(cfg.budget.scheduler)(optimizer)
    assert isinstance(scheduler, torch.optim.lr_scheduler.MultiStepLR)
    assert (scheduler.gamma, sorted(scheduler.milestones)) == (0.5, [200_000, 400_000])
    assert cfg.loss._target_.endswith("L1")
    assert (cfg.task.jitter, cfg.task.scale) == ("halton16", 2)
    assert laptop.budget.steps != cfg.budget.steps
