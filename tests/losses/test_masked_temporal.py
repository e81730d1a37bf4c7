import math

import numpy as np
import pytest
import torch

from supersampling.errors import UserError
from supersampling.losses import MaskedTemporal


def bilinear(image, x, y):
    """Interpolate ``image (C, H, W)`` at a position in pixels, whose centres are at + 0.5; the border is repeated."""
    _, height, width = image.shape
    x, y = min(max(x - 0.5, 0.0), width - 1.0), min(max(y - 0.5, 0.0), height - 1.0)
    j, i = math.floor(x), math.floor(y)
    right, below = min(j + 1, width - 1), min(i + 1, height - 1)
    fx, fy = x - j, y - i
    top = (1 - fx) * image[:, i, j] + fx * image[:, i, right]
    return (1 - fy) * top + fy * ((1 - fx) * image[:, below, j] + fx * image[:, below, right])


def by_loops(outputs, motion, dual, scale, threshold, beta):
    """Evaluate equations 6 and 7 and the mask of section 3.2 pixel by pixel."""
    values = []
    for clip, vectors, duals in zip(outputs, motion, dual):
        for t in range(1, len(clip)):
            _, height, width = clip[t].shape
            h, w = height // scale, width // scale
            for i in range(height):
                for j in range(width):
                    position = (j + 0.5) / scale, (i + 0.5) / scale
                    (x, y), (dual_x, dual_y) = bilinear(vectors[t], *position), bilinear(duals[t], *position)
                    hidden = abs(dual_x - x) * w >= threshold or abs(dual_y - y) * h >= threshold
                    previous = bilinear(clip[t - 1], j + 0.5 + x * width, i + 0.5 + y * height)
                    for a, b in zip(previous, clip[t][:, i, j]):
                        d = 0.0 if hidden else a - b
                        values.append(d * d / (2 * beta) if abs(d) < beta else abs(d) - beta / 2)
    return np.mean(values)


def clip(b=2, frames=3, h=3, w=4, scale=2):
    rng = np.random.default_rng(0)
    outputs = 3.0 * rng.normal(size=(b, frames, 3, h * scale, w * scale))
    motion = 0.2 * rng.normal(size=(b, frames, 2, h, w))
    dual = motion + np.where(rng.random((b, frames, 1, h, w)) < 0.5, 0.04 * rng.normal(size=motion.shape), 0.0)
    return outputs, motion, dual


@pytest.mark.parametrize(("threshold", "beta"), [(0.1, 1.0), (0.02, 0.3)])
def test_loss_equals_equation_7(threshold, beta):
    outputs, motion, dual = clip()
    frames = {"motion": torch.from_numpy(motion), "motion_dual": torch.from_numpy(dual)}
    loss = MaskedTemporal(threshold, beta)
    value = loss(torch.from_numpy(outputs), torch.zeros(outputs.shape), frames).item()
    expected = by_loops(outputs, motion, dual, 2, threshold, beta)
    assert value == pytest.approx(expected, rel=1e-9)
    # Some pixels are hidden.
    assert value < by_loops(outputs, motion, motion, 2, threshold, beta)
    assert (loss.requires, loss.previous) == ({"motion", "motion_dual"}, 1)


def test_hidden_and_static_pixels_cost_nothing():
    outputs, motion, _ = (torch.from_numpy(x) for x in clip())
    hidden = {"motion": motion, "motion_dual": motion + 1.0}
    assert MaskedTemporal(0.1, 1.0)(outputs, outputs, hidden).item() == 0.0
    still = {"motion": torch.zeros_like(motion), "motion_dual": torch.zeros_like(motion)}
    static = outputs[:, :1].expand_as(outputs).clone().requires_grad_()
    loss = MaskedTemporal(0.1, 1.0)(static, outputs, still)
    loss.backward()
    assert loss.item() == 0.0
    assert static.grad.isfinite().all()


@pytest.mark.parametrize("threshold", [0.0, -0.1, float("nan")])
def test_invalid_parameters_are_rejected(threshold):
    with pytest.raises(UserError, match=f"Invalid threshold={threshold}"):
        MaskedTemporal(threshold, 1.0)
    with pytest.raises(UserError, match="Invalid beta=0"):
        MaskedTemporal(0.1, 0.0)


def test_nan_motion_gives_a_finite_loss_and_gradient():
    torch.manual_seed(0)
    outputs = torch.rand(1, 2, 3, 8, 8, requires_grad=True)
    motion = torch.zeros(1, 2, 2, 4, 4)
    motion[:, 1, :, 2, 1] = torch.nan
    value = MaskedTemporal(0.1, 1.0)(outputs, outputs.detach(), {"motion": motion, "motion_dual": motion})
    (gradient,) = torch.autograd.grad(value, outputs)
    assert value.isfinite()
    assert gradient.isfinite().all()
