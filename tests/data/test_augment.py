"""Augmented samples are consistent: their frames show the augmented pattern from the augmented positions."""

import numpy as np
import pytest
import torch
import torch.nn.functional as F

from supersampling.data.augment import Chain, Colours, Symmetries
from supersampling.data.clips import Cut, WindowDataset
from supersampling.data.pick import Uniform
from supersampling.errors import UserError

FULL = Chain([Symmetries(), Colours(0.4)])
ALL = frozenset({"color", "depth", "motion", "jitter"})


def misfit(item: dict[str, torch.Tensor]) -> tuple[float, float]:
    """Return the mean error of the samples against the target at their positions, and of the warped previous target."""
    target, color = item["target"], item["color"][-len(item["target"]) :]
    height, width = color.shape[-2:]
    y, x = torch.meshgrid(torch.arange(height) + 0.5, torch.arange(width) + 0.5, indexing="ij")
    centres = torch.stack((x / width, y / height), dim=-1)
    jitter = item["jitter"][-len(target) :, None, None] / torch.tensor((width, height))
    seen = F.grid_sample(target, 2 * (centres + jitter) - 1, align_corners=False, padding_mode="border")
    sampling = (seen - color).abs().mean().item()
    motion = F.interpolate(item["motion"][-1:], scale_factor=4, mode="nearest").permute(0, 2, 3, 1)
    y, x = torch.meshgrid(torch.arange(4 * height) + 0.5, torch.arange(4 * width) + 0.5, indexing="ij")
    positions = torch.stack((x / (4 * width), y / (4 * height)), dim=-1) + motion
    carried = F.grid_sample(target[-2:-1], 2 * positions - 1, align_corners=False)
    inside = ((positions > 0.06) & (positions < 0.94)).all(-1)[0]
    return sampling, (carried - target[-1:]).abs().mean(1)[0][inside].mean().item()


@pytest.fixture
def items(make_file, tmp_path):
    data = WindowDataset([make_file(tmp_path, clips=4)], Cut(32, 6, 3), ALL, Uniform(), FULL, seed=3)
    return [data[k] for k in range(24)]


def test_samples_and_motion_stay_consistent(items):
    for item in items:
        sampling, warping = misfit(item)
        assert sampling < 0.02
        assert warping < 0.02


def test_wrong_signs_would_be_noticed(items):
    worst = [0.0, 0.0]
    for item in items:
        sampling, _ = misfit({**item, "jitter": -item["jitter"]})
        _, warping = misfit({**item, "motion": -item["motion"]})
        worst = [max(worst[0], sampling), max(worst[1], warping)]
    assert min(worst) > 0.05


def test_all_symmetries_occur(items):
    """Eight symmetries, observed by their effect on known numbers."""
    item = {"motion": np.broadcast_to(np.array((1.0, 2.0), np.float32)[None, :, None, None], (1, 2, 2, 2))}
    rng = np.random.default_rng(0)
    seen = [Symmetries()(item, rng) for _ in range(300)]
    assert len({tuple(s["motion"][0, :, 0, 0].tolist()) for s in seen}) == 8


def test_colours_change_order_and_brightness_of_input_and_target_alike():
    rng = np.random.default_rng(0)
    image = np.array((1.0, 0.5, 0.25), np.float32)[None, :, None, None] * np.ones((2, 3, 4, 4), np.float32)
    item = {"color": image, "target": image, "depth": image[:, :1]}
    seen = [Colours(0.5)(item, rng) for _ in range(200)]
    for changed in seen:
        np.testing.assert_array_equal(changed["color"], changed["target"])
        np.testing.assert_array_equal(changed["depth"], item["depth"])
        ratio = np.sort(changed["color"][0, :, 0, 0]) / np.array((0.25, 0.5, 1.0))
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-6)
    gains = [changed["color"].max() for changed in seen]
    assert 0.5 <= min(gains) < 0.55
    assert 0.95 < max(gains) <= 1.0
    assert len({tuple(np.argsort(changed["color"][0, :, 0, 0])) for changed in seen}) == 6


@pytest.mark.parametrize("darkest", [0.0, 1.5])
def test_invalid_gain_is_error(darkest):
    with pytest.raises(UserError, match=f"augment.darkest={darkest}: use a number above 0"):
        Colours(darkest)
