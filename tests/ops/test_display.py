"""Tests of the display transform against its two published formulas."""

import math

import pytest
import torch

from supersampling.ops.display import radiance_to_display


def reference(x: float) -> float:
    """Evaluate Narkowicz's quotient and IEC 61966-2-1 in float64."""
    x = max(x, 0.0)
    y = min((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 1.0)
    return 12.92 * y if y <= 0.0031308 else 1.055 * y ** (1.0 / 2.4) - 0.055


@pytest.mark.parametrize("radiance", [0.0, 1e-4, 0.003, 0.01, 0.18, 0.5, 1.0, 3.0, 20.0, -1.0])
def test_value(radiance):
    assert radiance_to_display(torch.tensor(radiance)).item() == pytest.approx(reference(radiance), abs=2e-6)


def test_known_values():
    """1 maps to 2.54 / 3.16 = 0.80380 linear; sRGB of that is 0.90825."""
    assert radiance_to_display(torch.tensor(1.0)).item() == pytest.approx(
        1.055 * 0.8037975 ** (1 / 2.4) - 0.055, abs=1e-5
    )
    assert radiance_to_display(torch.tensor([65504.0, 1e30, math.inf])).tolist() == pytest.approx([1.0, 1.0, 1.0])


def test_it_is_monotonic_with_finite_gradients():
    x = torch.linspace(0.0, 8.0, 20001, requires_grad=True)
    y = radiance_to_display(x)
    assert (y.diff() >= 0.0).all()
    y.sum().backward()
    assert torch.isfinite(x.grad).all()
