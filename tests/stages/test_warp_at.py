"""Both resolutions against a bilinear warp written as a loop, and where theory says that they agree."""

import math

import pytest
import torch

from supersampling.stages.upsample import BilinearUpsampling, ZeroUpsampling
from supersampling.stages.warp_at import LowResolution, TargetResolution

STAGES = [TargetResolution(), LowResolution()]


def look_up(image, x, y):
    """Return ``image (C, H, W)`` at a position in pixels; the border is repeated, and zero lies outside the image."""
    _, height, width = image.shape
    if not (0 <= x <= width and 0 <= y <= height):
        return torch.zeros_like(image[:, 0, 0])
    x, y = min(max(x - 0.5, 0.0), width - 1.0), min(max(y - 0.5, 0.0), height - 1.0)
    left, top = min(int(x), max(width - 2, 0)), min(int(y), max(height - 2, 0))
    fx, fy = x - left, y - top
    right, bottom = min(left + 1, width - 1), min(top + 1, height - 1)
    return (
        image[:, top, left] * (1 - fx) * (1 - fy)
        + image[:, top, right] * fx * (1 - fy)
        + image[:, bottom, left] * (1 - fx) * fy
        + image[:, bottom, right] * fx * fy
    )


def warp_by_loops(image, motion):
    """Warp ``image (C, H, W)`` by ``motion (2, H, W)`` in units of the image."""
    _, height, width = image.shape
    out = torch.zeros_like(image)
    for i in range(height):
        for j in range(width):
            x = j + 0.5 + float(motion[0, i, j]) * width
            y = i + 0.5 + float(motion[1, i, j]) * height
            out[:, i, j] = look_up(image, x, y)
    return out


def enlarge(motion, scale):
    """Upsample ``(2, h, w)`` bilinearly, with borders repeated."""
    _, h, w = motion.shape
    out = torch.zeros(2, h * scale, w * scale, dtype=motion.dtype)
    for i in range(h * scale):
        for j in range(w * scale):
            y, x = (i + 0.5) / scale, (j + 0.5) / scale
            out[:, i, j] = look_up(motion, x, y)
    return out


def buffers(h=4, w=5, c=3, reach=0.2, seed=0):
    g = torch.Generator().manual_seed(seed)
    features = torch.rand(2, c, h, w, generator=g, dtype=torch.float64)
    motion = (torch.rand(2, 2, h, w, generator=g, dtype=torch.float64) - 0.5) * 2 * reach
    jitter = torch.rand(2, 2, generator=g, dtype=torch.float64) - 0.5
    return features, motion, jitter


@pytest.mark.parametrize("upsample", [ZeroUpsampling(), BilinearUpsampling()])
def test_target_resolution_is_upsample_then_warp(upsample):
    features, motion, jitter = buffers()
    stage = TargetResolution()
    window = stage.enter(features, jitter, 3, upsample)
    out = stage.leave(stage(stage.keep(window, jitter), motion, jitter), jitter, 3, upsample)
    for n in range(2):
        expected = warp_by_loops(upsample(features, jitter, 3)[n], enlarge(motion[n], 3))
        torch.testing.assert_close(out[n], expected, rtol=0, atol=1e-11)
    came_from_outside = (out == 0).all(dim=1)
    assert 0 < came_from_outside.sum() < came_from_outside.numel()


@pytest.mark.parametrize("upsample", [ZeroUpsampling(), BilinearUpsampling()])
def test_low_resolution_is_warp_then_upsample(upsample):
    features, motion, jitter = buffers()
    previous = torch.tensor([[0.3, -0.1], [0.0, 0.4]], dtype=torch.float64)
    stage = LowResolution()
    window = stage.enter(features, previous, 3, upsample)
    out = stage.leave(stage(stage.keep(window, previous), motion, jitter), jitter, 3, upsample)
    size = torch.tensor([5.0, 4.0], dtype=torch.float64)
    for n in range(2):
        moved = motion[n] + ((jitter - previous)[n] / size)[:, None, None]
        expected = upsample(warp_by_loops(features[n], moved)[None], jitter[n : n + 1], 3)[0]
        torch.testing.assert_close(out[n], expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("stage", "scale"), [(TargetResolution(), 3), (LowResolution(), 1)])
def test_zero_motion_is_the_exact_identity(stage, scale):
    window = torch.rand(2, 7, 9 * scale, 11 * scale)
    jitter = torch.rand(2, 2) - 0.5
    assert torch.equal(stage(stage.keep(window, jitter), torch.zeros(2, 2, 9, 11), jitter), window)


def test_at_low_resolution_a_still_plane_follows_the_change_of_jitter():
    h, w = 6, 7
    before, now = torch.tensor([0.3, -0.4]).double(), torch.tensor([-0.2, 0.45]).double()

    def sampled(jitter):
        y = torch.arange(h, dtype=torch.float64)[:, None] + 0.5 + jitter[1]
        x = torch.arange(w, dtype=torch.float64) + 0.5 + jitter[0]
        return (0.3 * x + 0.7 * y)[None, None]

    stage = LowResolution()
    out = stage(stage.keep(sampled(before), before[None]), torch.zeros(1, 2, h, w).double(), now[None])
    torch.testing.assert_close(out[..., 1:-1, 1:-1], sampled(now)[..., 1:-1, 1:-1], rtol=0, atol=1e-12)


def test_both_resolutions_agree_on_motion_by_whole_pixels():
    features, _, jitter = buffers(h=6, w=8)
    motion = torch.zeros(2, 2, 6, 8, dtype=torch.float64)
    motion[:, 0], motion[:, 1] = 2.0 / 8, -1.0 / 6
    shown = []
    for stage in STAGES:
        window = stage.enter(features, jitter, 4, ZeroUpsampling())
        shown.append(stage.leave(stage(stage.keep(window, jitter), motion, jitter), jitter, 4, ZeroUpsampling()))
    torch.testing.assert_close(shown[0], shown[1], rtol=0, atol=1e-11)
    first = math.floor((0.5 + float(jitter[0, 0])) * 4), math.floor((0.5 + float(jitter[0, 1])) * 4)
    torch.testing.assert_close(shown[0][0, :, 2 * 4 + first[1], 4 + first[0]], features[0, :, 1, 3])


@pytest.mark.parametrize("stage", STAGES)
def test_gradients(stage):
    features, motion, jitter = buffers(h=3, w=3, c=1)
    window = stage.enter(features, jitter, 2, ZeroUpsampling()).requires_grad_()
    assert torch.autograd.gradcheck(
        lambda x, m: stage(stage.keep(x, jitter), m, jitter), (window, motion.requires_grad_())
    )
