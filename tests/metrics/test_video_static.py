import math

import numpy as np
import pytest
import torch
from video_clips import score

from supersampling.errors import UserError
from supersampling.metrics.video.static import StaticDeviation


def frames(count, seed, height=4, width=5):
    generator = torch.Generator().manual_seed(seed)
    return [torch.rand(1, 3, height, width, generator=generator) for _ in range(count)]


def test_clip_at_rest_gives_numpys_deviation():
    outputs, targets = frames(18, 0), frames(18, 1)
    values = score(StaticDeviation(), outputs, targets, [torch.zeros(1, 2, 2, 2)] * 18)
    output, target = (255 * np.stack([f[0].numpy() for f in clip]).std(axis=0).mean() for clip in (outputs, targets))
    assert list(values.values()) == pytest.approx([output, target, 1.0], rel=1e-5)


def test_spans_equal_loop_over_pixels_and_frames():
    count, height, width, shortest = 30, 4, 5, 3
    outputs = frames(count, 2)
    rng = np.random.default_rng(3)
    still = rng.random((count, height, width)) < 0.75
    motions = [torch.from_numpy(~mask).float().expand(1, 2, -1, -1) * 0.1 for mask in still]
    values = score(StaticDeviation(shortest), outputs, outputs, motions)
    total = weight = 0.0
    for i in range(height):
        for j in range(width):
            span: list[np.ndarray] = []
            for t in range(count + 1):
                if t < count and still[t, i, j]:
                    span.append(outputs[t][0, :, i, j].numpy())
                    continue
                if len(span) >= shortest:
                    total += len(span) * np.std(span, axis=0).mean()
                    weight += len(span)
                span = []
    assert 0 < weight < still.sum()
    expected = (255 * total / weight, 255 * total / weight, weight / still.size)
    assert list(values.values()) == pytest.approx(expected, rel=1e-5)


def test_uncovered_background_does_not_mix_with_what_hid_it():
    images = [torch.full((1, 3, 4, 4), 0.9)] * 8 + [torch.full((1, 3, 4, 4), 0.1)] * 8
    still, moving = torch.zeros(1, 2, 4, 4), torch.full((1, 2, 4, 4), 0.2)
    values = score(StaticDeviation(), images, images, [moving] * 8 + [still] * 8)
    assert values["static_std"] == 0.0
    assert values["static_std_fraction"] == 0.5


def test_without_span_there_is_no_value():
    values = score(StaticDeviation(), frames(7, 0), frames(7, 0), [torch.zeros(1, 2, 4, 5)] * 7)
    assert math.isnan(values["static_std"])
    assert values["static_std_fraction"] == 0.0
    with pytest.raises(UserError, match="shortest=1"):
        StaticDeviation(1)
