"""Moved bytes against sums."""

import math

import pytest
from fake_time import Clock, WorkingMethod
from hydra.utils import instantiate
from omegaconf import OmegaConf

from supersampling.profiling.traffic import bytes_moved, workload


@pytest.mark.parametrize(("scale", "w", "h"), [(4, 480, 270), (2, 960, 540)])
def test_dlctus(composed, scale, w, h):
    """Colour, depth and motion in low resolution, a jitter, an image, a history of four channels, 78,112 weights."""
    model = composed(f"task.scale={scale}").model
    target = w * h * scale**2
    expected = 4 * (w * h * (3 + 1 + 2) + 2 + target * 3 + 2 * target * 4 + 78_112)
    assert bytes_moved(instantiate(model), w, h) == expected
    result = workload(OmegaConf.to_container(model, resolve=True), w, h)
    assert (result.parameters, result.bytes) == (78_112, expected)
    assert result.macs == (target // 16) * (32 * 8 * 16 + 8 * 32 * 32 * 9)


def test_method_without_state():
    assert bytes_moved(WorkingMethod(Clock()), 4, 6) == 4 * (4 * 6 * 3 + 8 * 12 * 3)


def test_state_that_fills_up_counts_at_full_size(composed):
    """NSRR keeps four previous frames of twelve channels at the target's size; it reads a jitter as well."""
    model = instantiate(composed("model=nsrr").model)
    parameters = sum(p.numel() for p in model.parameters())
    low, target = 16 * 8, 64 * 32
    assert bytes_moved(model, 16, 8) == 4 * (low * (3 + 1 + 2) + 2 + target * 3 + 2 * 4 * 12 * target + parameters)


def test_invalid_configuration_is_unknown():
    result = workload({"_target_": "supersampling.models.bicubic.Bicubic", "scale": -1}, 8, 8)
    assert (math.isnan(result.macs), math.isnan(result.bytes)) == (True, True)
