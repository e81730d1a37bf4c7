"""Gates are found where models and stages declare them, and applied without knowing a model."""

import pytest
import torch
from hydra.utils import instantiate
from torch import nn

from supersampling.models.base import Upsampler
from supersampling.stages.gate import OPEN, SHUT, Gate, bias_at, setting_at
from supersampling.stress.gates import GATES, hold

# Stored tables use these names of rows.
ROWS = {
    "bicubic": [],
    "dlctus": ["gate/o1 0", "gate/o1 1", "gate/accumulation 0", "gate/accumulation 1"],
    "enss_s": ["gate/mask 0", "gate/mask 1", "gate/feature 1"],
    "enss_s model/history=none": [],
    "nsrd": ["gate/cell keeps all", "gate/cell keeps nothing", "gate/gated 0", "gate/gated 1"],
    "nsrd model/recur=none": ["gate/gated 0", "gate/gated 1"],
    "nsrr_fast": ["reweight/0", "reweight/limit"],
    "nsrr_fast model/reweight=none": [],
    "tus": ["gate/alpha 0", "gate/alpha 1", "gate/sigma 1e-3", "gate/sigma 1e3"],
    "tus_thesis": ["gate/alpha 0", "gate/alpha 1"],
}


@pytest.mark.parametrize("name", ROWS)
def test_rows_of_each_model(entry, name):
    model, *overrides = name.split()
    if model == "enss_s":
        overrides.append("model.kernel_prediction.width=16")
    upsampler = instantiate(entry("stress", f"model={model}", *overrides).model)
    assert [gate.name for gate in GATES if gate.adjust(upsampler)] == ROWS[name]


def test_declared_gates_are_unique_and_each_is_a_row_of_some_model():
    names = [gate.name for gate in GATES]
    assert sorted(names) == sorted({row for rows in ROWS.values() for row in rows})


class Stage(nn.Module):
    extremes = (Gate("gate/half", "The first half of a stage's bias.", bias_at(SHUT, lambda m: m.conv.bias[:2])),)

    def __init__(self):
        super().__init__()
        self.conv = nn.Conv2d(3, 4, 1)


class Gated(Upsampler):
    extremes = (
        Gate("gate/strength 2", "A setting.", setting_at(2.0, "strength")),
        Gate("gate/missing", "A gate that this composition lacks.", bias_at(OPEN, lambda m: None)),
    )

    def __init__(self):
        super().__init__()
        self.strength, self.stage = 1.0, Stage()

    def forward(self, frame, state):
        raise NotImplementedError


def test_gates_of_models_and_stages_are_held_in_place():
    model = Gated()
    rest = model.stage.conv.bias[2:].clone()
    assert hold(model, "gate/half")
    assert model.stage.conv.bias.tolist()[:2] == [SHUT, SHUT]
    assert torch.equal(model.stage.conv.bias[2:], rest)
    assert hold(model, "gate/strength 2")
    assert model.strength == 2.0
    assert not hold(model, "gate/missing")
    assert not hold(model, "gate/o1 0")
