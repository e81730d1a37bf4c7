import math

import numpy as np
import pytest
import torch

from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.tus import TUS, TUSThesis
from supersampling.ops.resample import jitter_aligned_upsample
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


def thesis_of_loops(history, color, jitter, scale, alpha):
    """2.4.4 and 2.4.6 with Yang's box, pixel by pixel: clamp to the nine samples around, then blend the pixel's own."""
    h, w, _ = color.shape
    output = np.empty_like(history)
    for row, column in np.ndindex(h * scale, w * scale):
        i, j = row // scale, column // scale
        around = color[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].reshape(-1, 3)
        value = np.clip(history[row, column], around.min(axis=0), around.max(axis=0))
        x, y = (j + 0.5 + jitter[0]) * scale, (i + 0.5 + jitter[1]) * scale  # of the sample, in target pixels
        inside = column <= x < column + 1 and row <= y < row + 1
        output[row, column] = alpha * color[i, j] + (1 - alpha) * value if inside else value
    return output


@pytest.mark.parametrize(("scale", "alpha"), [(2, 0.5), (4, 1.0), (3, 0.5), (6, 1.0)])
def test_thesis_equals_loops(scale, alpha):
    """Two frames of a still image: the thesis's alphas at its two scales, and the next smaller one's at others."""
    rng = np.random.default_rng(scale)
    model = TUSThesis(scale, None, Bilinear(), Clamp(RGB()), NoDilation(), JitterAligned())
    history = rng.random((4 * scale, 5 * scale, 3))
    state = torch.from_numpy(history).permute(2, 0, 1)[None]
    for jitter in rng.uniform(-0.49, 0.49, (2, 2)):
        color = rng.random((4, 5, 3))
        frame = Frame(
            color=torch.from_numpy(color).permute(2, 0, 1)[None],
            motion=torch.zeros(1, 2, 4, 5, dtype=torch.float64),
            jitter=torch.from_numpy(jitter)[None],
        )
        output, state = model(frame, state)
        history = thesis_of_loops(history, color, jitter, scale, alpha)
        np.testing.assert_allclose(output[0].permute(1, 2, 0).numpy(), history, atol=1e-12)


def test_thesis_starts_from_the_aligned_input_and_its_samples():
    """The first frame of DLCTUS, with the samples on top: at 4x4 each target pixel of the pattern is a sample."""
    color = torch.rand(1, 3, 4, 4, generator=torch.Generator().manual_seed(0))
    jitter = torch.tensor([[0.125, -0.375]])
    model = TUSThesis(4, None, Bilinear(), NoRectification(), NoDilation(), Zeros())
    output, _ = model(Frame(color=color, motion=torch.zeros(1, 2, 4, 4), jitter=jitter), None)
    expected = jitter_aligned_upsample(color, jitter, 4)
    torch.testing.assert_close(expected[..., 0::4, 2::4], color)  # the samples' own pixels
    torch.testing.assert_close(output, expected)


def test_thesis_alpha_can_be_set():
    model = TUSThesis(4, 0.25, Bilinear(), NoRectification(), NoDilation(), Zeros())
    assert model.alpha == 0.25
    with pytest.raises(UserError, match="Invalid model.alpha=2"):
        TUSThesis(4, 2.0, Bilinear(), NoRectification(), NoDilation(), Zeros())


@pytest.mark.parametrize(("sigma", "alpha"), [(0.0, 0.5), (-1.0, 0.5), (0.8, 1.5), (0.8, -0.1)])
def test_settings_out_of_range_raise(sigma, alpha):
    with pytest.raises(UserError, match="Invalid model"):
        tus(sigma=sigma, alpha=alpha)
