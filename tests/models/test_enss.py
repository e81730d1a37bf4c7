"""ENSS against a plain transcription of Mercier et al. 2023, section 4, and its counts against an independent count."""

import math
from pathlib import Path

import pytest
import torch
import torch.nn.functional as F
from enss_cases import clip, enss, run
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from supersampling.frames import Frame
from supersampling.stages.confine import Clamp
from supersampling.stages.flow import TVL1, NoFlow
from supersampling.stages.history import Blended, NoHistory, Unblended
from supersampling.stages.kernel_prediction import NoPrediction

CONF = Path(__file__).parents[2] / "conf"
SIZES = {"s": (16, 1), "m": (32, 3), "l": (64, 5)}  # f, m of section 5
# A transcription of the paper


def fetch(image, y, x):
    """Fetch ``(C, H, W)`` bilinearly at a position in pixels, with borders repeated."""
    _, height, width = image.shape
    y, x = min(max(y - 0.5, 0.0), height - 1.0), min(max(x - 0.5, 0.0), width - 1.0)
    i, j = math.floor(y), math.floor(x)
    below, right, fy, fx = min(i + 1, height - 1), min(j + 1, width - 1), y - i, x - j
    upper = (1 - fx) * image[:, i, j] + fx * image[:, i, right]
    lower = (1 - fx) * image[:, below, j] + fx * image[:, below, right]
    return (1 - fy) * upper + fy * lower


def paper_warp(history, motion, depth, scale):
    """Warp one item as in section 4.1: blocks of 8x8, then a bilinear fetch per pixel."""
    _, height, width = history.shape
    warped = torch.empty_like(history)
    for y in range(height):
        for x in range(width):
            rows = range(y // 8 * 8, min(y // 8 * 8 + 8, height))
            columns = range(x // 8 * 8, min(x // 8 * 8 + 8, width))
            low = [(i // scale, j // scale) for i in rows for j in columns]
            front = min(low, key=lambda p: (depth[0, p[0], p[1]].item(), p))
            dx, dy = motion[:, front[0], front[1]].tolist()
            warped[:, y, x] = fetch(history, y + 0.5 + dy * height, x + 0.5 + dx * width)
    return warped


def paper_step(model, color, depth, motion, jitter, history):
    """Return output and history of one item (section 4.2); ``history`` is (4, H, W) or None."""
    s, (_, h, w) = model.scale, color.shape
    if history is None:
        start = torch.zeros(4, h * s, w * s, dtype=color.dtype)
        for y in range(h * s):
            for x in range(w * s):
                place = ((y + 0.5) / s - jitter[1].item(), (x + 0.5) / s - jitter[0].item())
                start[:3, y, x] = fetch(color, *place)
        warped = start
    else:
        warped = paper_warp(history, motion, depth, s)
    planes = [*color, *depth, jitter[0].expand(h, w), jitter[1].expand(h, w)]
    for channel in warped:  # space-to-depth
        planes += [channel[i::s, j::s] for i in range(s) for j in range(s)]
    x = torch.stack(planes)[None]
    network = model.network
    predicted = network.kernels.mlp
    mlp = [*predicted.layers.parameters(), torch.cat([kernel.flatten() for kernel in predicted.bias])]
    y = jitter
    for k in range(0, len(mlp), 2):
        y = mlp[k] @ y + mlp[k + 1]
        y = y.clamp_min(0) if k + 2 < len(mlp) else y
    f, inputs, outputs = network.first_bias.numel(), len(planes), 5 * s * s
    first, last = y[: 9 * f * inputs].view(f, inputs, 3, 3), y[9 * f * inputs :].view(outputs, f, 3, 3)
    x = F.conv2d(x, first, network.first_bias, padding=1).clamp_min(0)
    for conv in network.body:
        x = F.conv2d(x, conv.weight, conv.bias, padding=1).clamp_min(0)
    x = F.conv2d(x, last, network.last_bias, padding=1)[0]
    high = torch.empty(5, h * s, w * s, dtype=x.dtype)
    for k in range(outputs):  # depth-to-space
        high[k // s**2, k % s**2 // s :: s, k % s :: s] = x[k]
    candidate, alpha = high[:3].clamp(0, 1), 1 / (1 + torch.exp(-high[3:4]))
    output = alpha * candidate + (1 - alpha) * warped[:3]
    return output, torch.cat((output, torch.tanh(high[4:])))


@pytest.mark.parametrize(("scale", "h", "w"), [(2, 6, 5), (3, 3, 4)])
def test_equals_transcription_of_paper_over_a_clip(scale, h, w):
    model, buffers = (enss(scale, confine=Clamp()).double(), clip(frames=4, h=h, w=w, motion=0.2, dtype=torch.float64))
    with torch.no_grad():
        model.network.kernels.mlp.layers[-1].weight.normal_(0.0, 0.2)  # so that the jitter matters
        outputs, state = run(model, buffers)
        for n in range(2):
            history = None
            for t in range(4):
                inputs = [buffers[name][n, t] for name in ("color", "depth", "motion", "jitter")]
                expected, history = paper_step(model, *inputs, history)
                torch.testing.assert_close(outputs[n, t], expected, rtol=0, atol=1e-12)
            torch.testing.assert_close(state[0][n], history, rtol=1e-12, atol=1e-12)


def test_identities_are_added_to_smaller_random_kernels():
    """Input c < 3 reaches all four positions of output c; the rest are PyTorch's kernels at 0.3."""
    model = enss(2, features=8, depth=1, kernel_prediction=NoPrediction)
    torch.manual_seed(0)
    drawn = [torch.nn.Conv2d(a, b, 3).weight for a, b in ((22, 8), (8, 8), (8, 20))]
    network = model.network
    kernels = [network.kernels.first[0], network.body[0].weight, network.kernels.last[0]]
    first, middle, last = (a - 0.3 * b for a, b in zip(kernels, drawn))
    for difference in (first, middle):
        expected = torch.zeros_like(difference)
        for c in range(8):
            expected[c, c, 1, 1] = 1.0
        torch.testing.assert_close(difference, expected)
    expected = torch.zeros_like(last)
    for k in range(12):
        expected[k, k // 4, 1, 1] = 1.0
    torch.testing.assert_close(last, expected)


# Counts


def count_by_layers(features, depth, scale, *, with_mlp):
    """Count the parameters kernel by kernel, as the text lists them."""
    s2 = scale * scale
    inputs = 3 + 1 + 2 + 3 * s2 + s2  # C, D, J, W(Y), W(f)
    outputs = s2 + 3 * s2 + s2  # alpha, candidate, f
    kernels = 9 * inputs * features + 9 * features * outputs
    rest = features + depth * (9 * features * features + features) + outputs
    if not with_mlp:
        return kernels + rest
    return rest + (2 * 2048 + 2048) + 5 * (2048 * 2048 + 2048) + (2048 * kernels + kernels)


COUNTS = {  # deployed, trained
    ("s", 2): (8_404, 33_382_612), ("s", 3): (14_909, 46_660_157), ("s", 4): (24_016, 65_248_720),
    ("m", 2): (39_892, 45_800_404), ("m", 3): (52_877, 72_355_469), ("m", 4): (71_056, 109_532_560),
    ("l", 2): (208_916, 70_742_036), ("l", 3): (234_861, 123_852_141), ("l", 4): (271_184, 198_206_288),
}  # fmt: skip


@pytest.mark.parametrize(("size", "scale"), COUNTS)
def test_parameters_with_the_mlp_and_without(size, scale):
    features, depth = SIZES[size]
    expected = tuple(count_by_layers(features, depth, scale, with_mlp=m) for m in (False, True))
    assert COUNTS[size, scale] == expected
    kernels = {"model/kernel_prediction=none": expected[0], "model/kernel_prediction=both": expected[1]}
    for override, count in kernels.items():
        with initialize_config_dir(str(CONF), version_base="1.3"):
            config = compose(
                "train", ["scene=atrium", "budget=enss", f"model=enss_{size}", f"task.scale={scale}", override]
            )
        with torch.device("meta"):
            assert sum(p.numel() for p in instantiate(config.model).parameters()) == count


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_four_history_channels_at_target_resolution(scale):
    """Section 4.2: "our historical data only consists of 4 high-resolution channels compared to 48"."""
    _, state = run(enss(scale), clip(frames=2))
    assert [t.shape for t in state] == [(2, 4, 5 * scale, 6 * scale)]
    assert Blended.carried == 4


def test_a_disabled_stage_leaves_no_parameters_and_no_inputs():
    s2, f = 4, 8
    plain = {"kernel_prediction": NoPrediction}
    whole = sum(p.numel() for p in enss(**plain).parameters())
    no_mask = sum(p.numel() for p in enss(history=Unblended(), **plain).parameters())
    assert whole - no_mask == s2 * (9 * f + 1)
    single = enss(history=NoHistory(), **plain)
    assert whole - sum(p.numel() for p in single.parameters()) == 2 * s2 * (9 * f + 1) + 4 * s2 * 9 * f
    assert single.requires == {"color", "depth", "jitter"}
    assert enss(flow=NoFlow()).requires == {"color", "depth", "jitter"}
    assert enss(flow=TVL1()).requires == {"color", "depth", "jitter"}
    assert enss().requires == {"color", "depth", "jitter", "motion"}
    assert run(single, clip())[1] == ()


@torch.no_grad()
def test_step_images_are_the_parts_of_equation_3():
    """The output is the blend of the pictures by the mask, and the reprojected one is the paper's warp."""
    model = enss(scale=2).double()
    for p in model.parameters():
        p.add_(torch.randn_like(p) * 0.05)
    buffers = clip(frames=3, b=1, dtype=torch.float64)
    state = None
    for t in range(3):
        frame = Frame.from_clip(buffers, t)
        images = model.pictured(frame, state)
        before = state
        output, state = model(frame, state)
        assert set(images) == {"reprojected", "candidate", "mask"}
        assert all(image.min() >= 0 and image.max() <= 1 for image in images.values())
        blend = images["mask"] * images["candidate"] + (1 - images["mask"]) * images["reprojected"]
        torch.testing.assert_close(blend, output, rtol=0, atol=1e-12)
        if before is not None:
            warped = paper_warp(before[0][0], frame.motion[0], frame.depth[0], 2)
            torch.testing.assert_close(images["reprojected"][0], warped[:3], rtol=0, atol=1e-12)
    assert images["mask"].std() > 0.01
    assert model.over_time <= set(images)
    assert set(enss(history=Unblended()).pictured(Frame.from_clip(clip(), 0), None)) == {"reprojected"}
    assert enss(history=NoHistory()).pictured(Frame.from_clip(clip(), 0), None) == {}
