import math
from itertools import pairwise

import numpy as np
import pytest
import torch
from video_clips import blurred, pan, score

from supersampling.metrics.video.warping import DualMotion, Photometric, WarpingError


def test_equals_loop_over_pixels_of_pan():
    """Every pixel but the last column was one pixel to the right in the frame before."""
    generator = torch.Generator().manual_seed(0)
    outputs, targets = (
        [torch.rand(1, 3, 6, 9, generator=generator, dtype=torch.float64) for _ in range(4)] for _ in range(2)
    )
    motion = torch.zeros(1, 2, 6, 9, dtype=torch.float64)
    motion[:, 0] = 1 / 9

    def by_hand(frames):
        pairs = []
        for before, now in pairwise(frames):
            a, b = before[0].numpy(), now[0].numpy()
            errors = [(b[c, i, j] - a[c, i, j + 1]) ** 2 for c in range(3) for i in range(6) for j in range(8)]
            pairs.append(np.mean(errors))
        return np.mean(pairs)

    values = score(WarpingError(DualMotion()), outputs, targets, [motion] * 4, [motion] * 4)
    expected = (by_hand(outputs), by_hand(targets), by_hand(outputs) / by_hand(targets))
    assert list(values.values()) == pytest.approx(expected, rel=1e-9)


def test_hidden_pixels_do_not_count():
    target = torch.full((1, 3, 4, 8), 0.5)
    changed = target.clone()
    changed[..., :3] += 0.2
    changed[..., 5:] += 0.1
    motion, dual = torch.zeros(1, 2, 4, 8), torch.zeros(1, 2, 4, 8)
    dual[:, 1, :, :3] = 0.5
    values = score(WarpingError(DualMotion()), [target, changed], [target] * 2, [motion] * 2, [dual] * 2)
    assert values["warping_error"] == pytest.approx(0.01 * 3 / 5)
    assert values["warping_error_reference"] == 0.0
    assert math.isnan(values["warping_error_ratio"])


def test_photometric_weights_by_hand():
    target = torch.full((1, 3, 4, 8), 0.3)
    later, output = target.clone(), target.clone()
    later[..., 4:] += 0.1  # its weight is exp(-50 * 3 * 0.01)
    output[..., :4] += 0.2
    output[..., 4:] += 0.4
    motion = torch.zeros(1, 2, 2, 4)
    values = score(WarpingError(Photometric()), [target, output], [target, later], [motion] * 2)
    w = math.exp(-1.5)
    assert values["warping_error_photometric"] == pytest.approx((0.04 + w * 0.16) / (1 + w), rel=1e-5)
    assert values["warping_error_photometric_reference"] == pytest.approx(w * 0.01 / (1 + w), rel=1e-5)


def test_cut_and_single_frame_have_no_value():
    image, beyond = torch.rand(1, 3, 4, 8), torch.full((1, 2, 4, 8), 2.0)
    for count in (1, 2):
        values = score(WarpingError(DualMotion()), [image] * count, [image] * count, [beyond] * 2, [beyond] * 2)
        assert all(math.isnan(value) for value in values.values())


def test_blur_beats_flickering_reference():
    """The reason for the ratio: it shows that the output changes less along the motion than the reference."""
    targets, motions = pan(4, step=3)  # upsampled, no whole number of low-resolution pixels
    shaded = [t + 0.02 * (-1) ** i * (t > 0.5) for i, t in enumerate(targets)]
    values = score(WarpingError(DualMotion()), blurred(shaded, 3), shaded, motions, motions)
    assert values["warping_error_ratio"] < 0.9
