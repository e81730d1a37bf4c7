import math

import pytest
import torch

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.tus import TUS
from supersampling.stages.colour_space import RGB
from supersampling.stages.dilate import ClosestDepth, NoDilation
from supersampling.stages.pad import JitterAligned, Zeros
from supersampling.stages.rectify import Clamp, NoRectification
from supersampling.stages.reproject import Bilinear


def tus(scale=2, sigma=0.8, alpha=0.5, rectify=None, dilate=None, pad=None):
    return TUS(scale, sigma, alpha, Bilinear(), rectify or NoRectification(), dilate or NoDilation(), pad or Zeros())


def test_blends_a_sample_into_history_by_alpha_beta():
    """One sample, scale 1, at the sample's distance from the pixel centre: eqs 39, 41, 42 in closed form."""
    model = tus(scale=1, sigma=0.8, alpha=0.5)
    frame = Frame(
        color=torch.full((1, 3, 1, 1), 0.9), motion=torch.zeros(1, 2, 1, 1), jitter=torch.tensor([[0.3, -0.2]])
    )
    output, _ = model(frame, torch.full((1, 3, 1, 1), 0.1))
    weight = 0.5 * math.exp(-(0.3**2 + 0.2**2) / (2 * 0.8**2))
    torch.testing.assert_close(output, torch.full((1, 3, 1, 1), 0.1 + weight * 0.8))


def test_the_first_frame_starts_from_the_aligned_input():
    frame = Frame(
        color=torch.full((1, 3, 4, 4), 0.6), motion=torch.zeros(1, 2, 4, 4), jitter=torch.tensor([[0.25, 0.1]])
    )
    torch.testing.assert_close(tus()(frame, None)[0], torch.full((1, 3, 8, 8), 0.6))


def test_outside_the_image_the_history_is_padded():
    color = torch.full((1, 3, 4, 4), 0.6)
    frame = Frame(color=color, motion=torch.full((1, 2, 4, 4), 2.0), jitter=torch.zeros(1, 2))
    history = torch.full((1, 3, 8, 8), 0.2)
    torch.testing.assert_close(tus(pad=JitterAligned(), alpha=0.0)(frame, history)[0].mean(), torch.tensor(0.6))
    assert tus(pad=Zeros(), alpha=0.0)(frame, history)[0].max() == 0.0


def test_clamping_removes_a_ghost():
    color = torch.full((1, 3, 4, 4), 0.3)
    frame = Frame(color=color, motion=torch.zeros(1, 2, 4, 4), jitter=torch.zeros(1, 2))
    output, _ = tus(rectify=Clamp(RGB()), alpha=0.0)(frame, torch.full((1, 3, 8, 8), 0.9))
    torch.testing.assert_close(output, torch.full((1, 3, 8, 8), 0.3))


def test_static_image_accumulates_to_full_resolution():
    """Samples at the four target pixel centres of 2x2, in turn: the history must converge to the target."""
    target = torch.rand(1, 3, 8, 8, generator=torch.Generator().manual_seed(1))
    model, state = tus(sigma=0.3, alpha=0.5), None
    for t in range(80):
        row, column = (t // 2) % 2, t % 2
        jitter = torch.tensor([[column * 0.5 - 0.25, row * 0.5 - 0.25]])
        frame = Frame(color=target[..., row::2, column::2], motion=torch.zeros(1, 2, 4, 4), jitter=jitter)
        output, state = model(frame, state)
    torch.testing.assert_close(output, target, rtol=0, atol=0.01)


def test_dilation_adds_depth_to_required_buffers():
    assert tus().requires == {"color", "jitter", "motion"}
    assert tus(dilate=ClosestDepth()).requires == {"color", "jitter", "motion", "depth"}


@pytest.mark.parametrize(("sigma", "alpha"), [(0.0, 0.5), (-1.0, 0.5), (0.8, 1.5), (0.8, -0.1)])
def test_settings_out_of_range_raise(sigma, alpha):
    with pytest.raises(UserError, match="Invalid model"):
        tus(sigma=sigma, alpha=alpha)
