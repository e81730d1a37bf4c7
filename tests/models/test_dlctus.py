"""DLCTUS against a plain transcription of the thesis's appendix A.1, in the thesis's own conventions."""

import pytest
import torch
import torch.nn.functional as F

from supersampling.frames import Frame
from supersampling.models.dlctus import DLCTUS, Trunk
from supersampling.stages.accumulate import AccumulationBuffer, NoAccumulation
from supersampling.stages.confine import Clamp, StraightThrough
from supersampling.stages.dilate import NoDilation
from supersampling.stages.initialise import Balanced, Published
from supersampling.stages.pad import JitterAligned
from supersampling.stages.reproject import Bicubic9


def thesis_convolution(x, conv, stride, pad):
    if pad:
        x = F.pad(x, (1, 1, 1, 1), mode="replicate")
    return F.conv2d(x, conv.weight, conv.bias, stride=stride)


def thesis_network(x, trunk):
    x = thesis_convolution(x, trunk.down, 4, pad=False)
    for block in trunk.blocks:
        inner = thesis_convolution(x, block[0], 1, pad=True)
        inner = torch.maximum(inner, torch.zeros_like(inner))
        x = x + thesis_convolution(inner, block[2], 1, pad=True)
    b, _, h, w = x.shape
    out = torch.zeros(b, 2, 4 * h, 4 * w, dtype=x.dtype)
    for k in range(32):  # channel k fills one place of every 4x4 block of output k // 16
        out[:, k // 16, (k % 16) // 4 :: 4, k % 4 :: 4] = x[:, k]
    return out


def thesis_step(trunk, factor, color, depth, grid, jitter, history):
    """One frame. ``jitter (B, 2)`` in [0, 1); ``grid (B, h, w, 2)`` absolute previous positions in [-1, 1]."""
    b, _, h, w = color.shape
    size = (b, 4, h * factor, w * factor)
    theta = torch.zeros(b, 2, 3, dtype=color.dtype)
    for n in range(b):
        theta[n, 0, 0] = theta[n, 1, 1] = 1.0
        theta[n, 0, 2] = 2.0 * (0.5 - jitter[n, 0]) / w
        theta[n, 1, 2] = 2.0 * (0.5 - jitter[n, 1]) / h
    with_ones = torch.cat((color, torch.ones(b, 1, h, w, dtype=color.dtype)), 1)
    lattice = F.affine_grid(theta, size, align_corners=False)
    aligned = F.grid_sample(with_ones, lattice, "bilinear", "border", align_corners=False)

    sparse = torch.zeros(size, dtype=color.dtype)
    for n in range(b):
        column, row = (int(v) for v in torch.floor(jitter[n] * factor))
        sparse[n, :, row::factor, column::factor] = torch.cat((color, depth), 1)[n]

    if history is None:
        history = aligned
    else:
        identity = torch.tensor([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]], dtype=color.dtype).expand(b, -1, -1)
        offset = grid - F.affine_grid(identity, [b, 2, h, w], align_corners=False)
        offset = F.interpolate(offset.permute(0, 3, 1, 2), scale_factor=factor, mode="bilinear")
        fine = offset.permute(0, 2, 3, 1) + F.affine_grid(identity, size, align_corners=False)
        warped = F.grid_sample(history, fine, "bicubic", "border", align_corners=False)
        for n, i, j in torch.nonzero((fine > 1.0).any(-1) | (fine < -1.0).any(-1)).tolist():
            warped[n, :, i, j] = aligned[n, :, i, j]
        history = warped

    o = thesis_network(torch.cat((sparse, history), 1), trunk).clamp(0.0, 1.0)
    history = history * (1.0 - o[:, :1]) + aligned * o[:, :1]
    history = torch.cat((history[:, :3], history[:, 3:] * o[:, 1:]), 1).clamp(0.0, 1.0)
    return history[:, :3], history


def dlctus(scale, accumulate=None, confine=None, initialise=None):
    return DLCTUS(
        scale,
        Bicubic9(),
        NoDilation(),
        JitterAligned(),
        accumulate or AccumulationBuffer(),
        confine or Clamp(),
        initialise or Published(),
    )


def clip_frame(b, h, w, dtype):
    return {
        "color": torch.rand(b, 3, h, w, dtype=dtype),
        "depth": torch.rand(b, 1, h, w, dtype=dtype),
        "motion": torch.randn(b, 2, h, w, dtype=dtype) * 0.1,
        "jitter": torch.rand(b, 2, dtype=dtype) - 0.5,
    }


@pytest.mark.parametrize(("scale", "h", "w"), [(4, 5, 6), (2, 6, 8)])
@pytest.mark.parametrize("confine", [Clamp, StraightThrough])
def test_equals_the_thesis_listing_over_a_clip(scale, h, w, confine):
    torch.manual_seed(3)
    model = dlctus(scale, confine=confine()).double()
    state = history = None
    x = (2 * torch.arange(w, dtype=torch.float64) + 1) / w - 1
    y = (2 * torch.arange(h, dtype=torch.float64)[:, None] + 1) / h - 1
    lattice = torch.stack((x.expand(h, w), y.expand(h, w)), -1)
    left_the_image = 0
    with torch.no_grad():
        for _ in range(5):
            frame = clip_frame(2, h, w, torch.float64)
            output, state = model(Frame(**frame), state)
            grid = lattice + 2.0 * frame["motion"].permute(0, 2, 3, 1)  # [-1, 1] is two image units wide
            left_the_image += int((grid.abs() > 1).sum())
            jitter = frame["jitter"] + 0.5
            expected, history = thesis_step(model.network, scale, frame["color"], frame["depth"], grid, jitter, history)
            torch.testing.assert_close(output, expected, rtol=0, atol=1e-11)
            torch.testing.assert_close(state, history, rtol=0, atol=1e-11)
    assert left_the_image > 10


def test_parameter_count_of_published_network():
    assert sum(p.numel() for p in dlctus(4).parameters()) == 78_112


def test_without_accumulation_only_the_first_layer_shrinks():
    model = dlctus(4, accumulate=NoAccumulation())
    assert sum(p.numel() for p in model.parameters()) == 78_112 - 32 * 16
    _, state = model(Frame(**clip_frame(1, 3, 3, torch.float32)), None)
    assert state.shape[1] == 3


@pytest.mark.parametrize(("height", "width"), [(1, 1), (6, 9), (15, 4)])
def test_sizes_not_divisible_by_four_are_padded_by_repetition(height, width):
    trunk = Trunk(8)
    x = torch.rand(1, 8, height, width)
    rows = torch.arange(-(-height // 4) * 4).clamp_max(height - 1)
    columns = torch.arange(-(-width // 4) * 4).clamp_max(width - 1)
    whole = trunk(x[:, :, rows][..., columns])
    assert torch.equal(trunk(x), whole[..., :height, :width])


def test_balanced_initialisation_leaves_few_outputs_saturated():
    torch.manual_seed(0)
    frame = Frame(**clip_frame(2, 16, 16, torch.float32))
    outside = {}
    for name, initialise in (("published", Published()), ("balanced", Balanced())):
        model, seen = dlctus(4, initialise=initialise), []
        model.network.register_forward_hook(lambda *call, seen=seen: seen.append(call[2]))
        model(frame, None)
        outside[name] = ((seen[0] < 0) | (seen[0] > 1)).float().mean().item()
    assert outside["published"] > 0.3
    assert outside["balanced"] < 0.1


def test_exports_to_a_graph():
    model = dlctus(4, confine=StraightThrough()).eval()
    frame = clip_frame(1, 4, 4, torch.float32)
    state = torch.rand(1, 4, 16, 16)

    class Step(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.model = model

        def forward(self, color, depth, motion, jitter, state):
            return self.model(Frame(color=color, depth=depth, motion=motion, jitter=jitter), state)

    with torch.no_grad():
        exported = torch.export.export(Step(), (*frame.values(), state)).module()
        torch.testing.assert_close(exported(*frame.values(), state)[0], model(Frame(**frame), state)[0])
