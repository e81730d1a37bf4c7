"""Bytes against sums written here."""

import math

import pytest
from fake_time import Clock, Timed
from hydra.utils import instantiate
from omegaconf import OmegaConf

from supersampling.profiling.traffic import bytes_moved, work


@pytest.mark.parametrize(("scale", "w", "h"), [(4, 480, 270), (2, 960, 540)])
def test_dlctus(composed, scale, w, h):
    """Colour, depth and motion of a low-resolution pixel and a jitter; an image; a history of four channels; 78,112 weights."""
    model = composed(f"task.scale={scale}").model
    target = w * h * scale**2
    expected = 4 * (w * h * (3 + 1 + 2) + 2 + target * 3 + 2 * target * 4 + 78_112)
    assert bytes_moved(instantiate(model), w, h) == expected
    found = work(OmegaConf.to_container(model, resolve=True), w, h)
    assert (found.parameters, found.bytes) == (78_112, expected)
    assert found.macs == (target // 16) * (32 * 8 * 16 + 8 * 32 * 32 * 9)


def test_without_a_state():
    assert bytes_moved(Timed(Clock()), 4, 6) == 4 * (4 * 6 * 3 + 8 * 12 * 3)


def test_a_state_that_fills_up_is_counted_full(composed):
    """NSRR keeps four previous frames of twelve channels at the target's size; it reads a jitter as well."""
    model = instantiate(composed("model=nsrr").model)
    parameters = sum(p.numel() for p in model.parameters())
    low, target = 16 * 8, 64 * 32
    assert bytes_moved(model, 16, 8) == 4 * (low * (3 + 1 + 2) + 2 + target * 3 + 2 * 4 * 12 * target + parameters)


def test_what_is_not_possible_is_unknown():
    found = work({"_target_": "supersampling.models.bicubic.Bicubic", "scale": -1}, 8, 8)
    assert (math.isnan(found.macs), math.isnan(found.bytes)) == (True, True)
