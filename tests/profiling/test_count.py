"""Counts of parameters and operations against formulas."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate
from omegaconf import OmegaConf
from torch import nn

from supersampling.commands.count import count
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.bicubic import Bicubic
from supersampling.models.count import count_modules, size_of

ROOT = Path(__file__).resolve().parents[2]


class Window(Upsampler[Any]):
    """A small network: a stem whose forward is bypassed, one convolution per frame of a window that fills up to 3."""

    requires = frozenset({"color", "jitter", "high_normal"})

    def __init__(self):
        super().__init__()
        self.scale = 2
        self.stem = nn.Sequential(nn.Conv2d(3, 8, 3, padding=1), nn.Identity(), nn.Conv2d(8, 4, 1, bias=False))
        self.window = nn.Conv2d(4, 6, 5, stride=2, padding=2, groups=2)
        self.weight = nn.Parameter(torch.rand(2, 7))
        self.idle = nn.ReLU()

    def forward(self, frame, state):
        x = frame.color
        for layer in self.stem:
            x = layer(x)
        window = (x, *(state or ()))[:3]
        y = sum(self.window(w).mean() for w in window) + (frame.jitter @ self.weight).sum() + frame.high_normal.sum()
        return y.expand(1, 3, 2 * x.shape[-2], 2 * x.shape[-1]), window


def expected(h, w):
    """Return the MACs of one frame in steady state, by row."""
    half = -(-h // 2) * -(-w // 2)
    return {"stem": h * w * (8 * 3 * 9 + 4 * 8), "window": 3 * half * 6 * (4 // 2) * 25, "(its own)": 2 * 7}


@pytest.mark.parametrize("device", ["meta", "cpu"])
@pytest.mark.parametrize(("h", "w"), [(6, 8), (5, 7), (1, 1)])
def test_counts_are_the_formula(h, w, device):
    rows = {row.module: row for row in count_modules(Window(), w, h, device=device)}
    assert {name: row.macs for name, row in rows.items() if name != "total"} == expected(h, w)
    assert rows["total"].macs == sum(expected(h, w).values())
    parameters = {"stem": 3 * 8 * 9 + 8 + 8 * 4, "window": 6 * 2 * 25 + 6, "(its own)": 14}
    assert {name: row.parameters for name, row in rows.items() if name != "total"} == parameters
    assert rows["total"].parameters == sum(parameters.values())


def test_deeper_rows():
    rows = {row.module: row for row in count_modules(Window(), 8, 6, depth=2)}
    assert list(rows) == ["stem", "stem.0", "stem.2", "window", "(its own)", "total"]
    assert (rows["stem.0"].macs, rows["stem.2"].macs) == (48 * 216, 48 * 32)
    assert (rows["stem.0"].kind, rows["stem.0"].parameters) == ("Conv2d", 224)


@pytest.mark.parametrize(("scale", "w", "h"), [(4, 480, 270), (2, 960, 540)])
def test_dlctus(scale, w, h):
    """Figure 5: a strided 4x4 convolution of 8 to 32 channels and eight 3x3 ones of 32, at a quarter of the target."""
    total = count_modules(instantiate(composed(f"task.scale={scale}").model), w, h)[-1]
    assert total.parameters == 78_112
    assert total.macs == (w * scale // 4) * (h * scale // 4) * (32 * 8 * 16 + 8 * 32 * 32 * 9)


class ValueBranch(Window):
    def forward(self, frame, state):
        if frame.color.mean() > 0:
            return super().forward(frame, state)
        raise AssertionError


def test_method_that_branches_on_values_needs_a_device():
    with pytest.raises(UserError, match="device=cpu"):
        count_modules(ValueBranch(), 4, 4)
    assert count_modules(ValueBranch(), 8, 6, device="cpu")[-1].macs == sum(expected(6, 8).values())


class Growing(Window):
    def forward(self, frame, state):
        output, _ = super().forward(frame, None)
        return output, (*(state or ()), frame.color)


def test_endless_state_is_an_error():
    with pytest.raises(UserError, match="still grows"):
        count_modules(Growing(), 1, 1)


def test_groups_are_those_of_train():
    """Each composition for train.py composes for count.py, too."""
    groups = [OmegaConf.load(ROOT / "conf" / f"{name}.yaml").defaults for name in ("train", "count")]
    assert groups[0] == groups[1]


def composed(*overrides):
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        return compose("count", list(overrides))


def test_command():
    command = [sys.executable, "count.py", "experiment=dlctus", "size=[480,270]"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "experiment=dlctus size=[480,270]: 480x270 to 1920x1080" in done.stdout
    total = next(line for line in done.stdout.splitlines() if "total" in line)
    assert total.split() == ["total", "DLCTUS", "78,112", "78.11", "10.0860"]


@pytest.mark.parametrize("override", ["size=[480]", "size=[480,0]", "size=[4.5,4]", "depth=0", "depth=all"])
def test_invalid_settings(override):
    with pytest.raises(UserError, match=re.escape(override.replace(",", ", "))):
        count(composed(override))


def test_logged_size_of_a_run():
    """Bicubic interpolation has no weights and no counted operations; a method that branches on values has no count."""
    assert size_of(Bicubic(4)) == {"model/parameters": 0.0, "model/gmac": 0.0}
    size = size_of(Window().to("cpu"))
    assert size["model/parameters"] == 8 * 27 + 8 + 32 + 6 * 2 * 25 + 6 + 14
