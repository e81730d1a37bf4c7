"""The gain of a reprojection: its closed form, the response of the kernel, and the stage itself on waves."""

import math

import numpy as np
import pytest
import torch

from supersampling.stages.colour_space import RGB
from supersampling.stages.rectify import Clamp, NoRectification
from supersampling.stages.reproject import Bicubic9
from supersampling.stress.divergence import KERNELS, directed_growth, growth, tus_error, uniform_motion
from supersampling.stress.gain import Kernel, cubic_gain

BY_NAME = {kernel.name: (kernel, make) for kernel, make in KERNELS}


@pytest.mark.parametrize("a", [-1.0, -0.9, -0.75, -0.6, -0.5, -0.25, 0.0])
def test_closed_form_is_the_largest_response_over_fractions_and_frequencies(a):
    f = np.linspace(0.0, 1.0, 101)
    w = np.linspace(-math.pi, math.pi, 2001)
    x = np.arange(-1, 3)[:, None, None] - f[:, None]  # distances from the position to its four pixels
    t = np.abs(x)
    near = (a + 2) * t**3 - (a + 3) * t**2 + 1
    far = a * t**3 - 5 * a * t**2 + 8 * a * t - 4 * a
    keys = np.where(t <= 1, near, np.where(t < 2, far, 0.0))  # Keys 1981, equation 4
    response = np.abs((keys * np.exp(1j * np.arange(-1, 3)[:, None, None] * w)).sum(axis=0))
    assert response.max() ** 2 == pytest.approx(cubic_gain(a), abs=1e-5)


def test_kernel_of_the_thesis_grows_by_six_percent_and_catmull_rom_does_not():
    assert cubic_gain(-0.75) == pytest.approx((7 / 6 * math.sqrt(7 / 9)) ** 2, abs=1e-12)
    assert cubic_gain(-0.5) == 1.0
    assert Kernel("", 9, -0.75).worst() == pytest.approx((cubic_gain(-0.75), 0.5, 0.5), abs=1e-9)


@pytest.mark.parametrize("name", BY_NAME)
@pytest.mark.parametrize(("fx", "fy"), [(0.5, 0.5), (0.25, 0.4), (0.0, 0.5)])
@pytest.mark.parametrize(("kx", "ky"), [(5, 5), (10, 3), (16, 16), (1, 0)])
def test_stage_changes_a_wave_by_the_response(name, fx, fy, kx, ky):
    """In the middle of the image, a reprojected wave is the wave times a complex number."""
    kernel, make = BY_NAME[name]
    side = 32
    wx, wy = 2 * math.pi * kx / side, 2 * math.pi * ky / side
    y, x = torch.meshgrid(*[torch.arange(side, dtype=torch.float64)] * 2, indexing="ij")
    phase = wx * x + wy * y
    image = torch.stack((phase.cos(), phase.sin()))[None]
    moved = make()(image, uniform_motion((fx, fy), side))
    wave = torch.complex(*moved[0]) / torch.complex(*image[0])
    truth = kernel.response(np.array(fx), np.array(fy), np.array(wx), np.array(wy))
    middle = wave[8:24, 8:24]
    assert torch.allclose(middle, middle[0, 0].expand_as(middle), atol=1e-9)
    assert middle[0, 0].abs().item() == pytest.approx(float(truth), abs=1e-9)


@pytest.mark.parametrize("name", BY_NAME)
def test_growth_is_below_the_gain_and_near_it(name):
    kernel, make = BY_NAME[name]
    value, _ = growth(make(), 0.5, side=48, frames=400)
    gain = kernel.gain(0.5, 0.5)
    assert gain - 0.006 < value <= gain + 1e-9


def test_growth_of_static_and_leaving_histories():
    assert growth(Bicubic9(-0.75), 0.0, side=8, frames=20)[0] == pytest.approx(1.0, abs=1e-12)
    assert directed_growth(Bicubic9(-0.75), 0.5, side=64) > 1.5 > 1.0 > directed_growth(Bicubic9(-0.5), 0.5, side=64)


def test_clamping_and_samples_limit_the_error():
    def make():
        return Bicubic9(-0.75)

    free, visible = tus_error(make, NoRectification(), 0.0, 160)
    clamped, _ = tus_error(make, Clamp(RGB()), 0.0, 160)
    sampled, invisible = tus_error(make, NoRectification(), 1.0, 160)
    assert free > 2 * clamped > 2 * sampled
    assert 0 < visible < 100
    assert invisible == -1
