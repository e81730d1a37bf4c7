"""The clip of every extreme has the property in the extreme's name."""

import math

import pytest
import torch

from supersampling.frames import BUFFERS
from supersampling.ops.demodulate import MIN_MATERIAL, demodulate
from supersampling.stress.clip import CYCLE, make_clip, make_inputs
from supersampling.stress.plan import EXTREMES

ALL = [name for name in BUFFERS if name != "object_id" and name != "high_object_id"]
BY_NAME = {extreme.name: extreme for extreme in EXTREMES}
W, H, SCALE = 12, 10, 4


def changed_clip(name):
    """Return the clip of the extreme called ``name``."""
    return BY_NAME[name].change(make_clip(ALL, 3, W, H, SCALE))


def test_names_are_unique():
    assert len(BY_NAME) == len(EXTREMES)


def test_plain_clip_is_in_range_and_moves_by_its_motion():
    clip = make_clip(ALL, 4, W, H, SCALE)
    for name, values in clip.items():
        assert values.isfinite().all(), name
        if BUFFERS[name].kind in ("display", "reflectance"):
            assert 0.0 <= values.min() <= values.max() <= 1.0
    # Without jitter, the content at x was at x + motion one frame before; it is smooth, so that a finer grid shows it.
    now, before = (make_inputs(["target", "motion"], t, W, H, 8) for t in (5, 4))
    dx = now["motion"][0, 0, 0, 0].item() * W * 8
    dy = now["motion"][0, 1, 0, 0].item() * H * 8
    x, y = 40, 33
    fx, fy = x + dx - math.floor(x + dx), y + dy - math.floor(y + dy)
    i, j = math.floor(y + dy), math.floor(x + dx)
    corners = before["target"][0, :, i : i + 2, j : j + 2]
    expected = (1 - fy) * ((1 - fx) * corners[:, 0, 0] + fx * corners[:, 0, 1]) + fy * (
        (1 - fx) * corners[:, 1, 0] + fx * corners[:, 1, 1]
    )
    assert torch.allclose(expected, now["target"][0, :, y, x], atol=2e-3)
    assert max(abs(dx), abs(dy)) > 1.0


def test_cycle_ends_at_its_beginning():
    first, second = (make_inputs(["color", "motion", "jitter"], t, 5, 4, 2) for t in (3, 3 + CYCLE))
    for name in first:
        assert torch.allclose(first[name], second[name], atol=1e-9)


@pytest.mark.parametrize(
    ("name", "width", "height"),
    [
        ("size/1x1", 1, 1), ("size/odd", 13, 7), ("size/1:100", 2, 200), ("size/100:1", 200, 2),
        ("size/8K wide", 7680 // 4, 2), ("size/8K tall", 2, 4320 // 4), ("size/8K target", 1920, 1080),
        ("size/8K input", 7680, 4320),
    ],
)  # fmt: skip
def test_sizes(name, width, height):
    assert BY_NAME[name].low_size((W, H), 4) == (width, height)


def test_scales_are_one_to_eight():
    assert sorted(e.scale for e in EXTREMES if e.group == "scale") == list(range(1, 9))


def test_colours():
    assert changed_clip("colour/black")["color"].abs().max() == 0
    assert changed_clip("colour/white")["color"].min() == 1
    assert changed_clip("colour/white")["radiance"].min() == 65504
    hot = changed_clip("colour/hot pixel")
    assert (hot["color"][0, 0, 0] > 0).sum() == 1
    assert (hot["target"][0, 0, 0] > 0).sum() == 1
    checks = changed_clip("colour/checkerboard")["color"]
    assert (checks.diff(dim=-1).abs() == 1).all()
    assert (checks.diff(dim=-2).abs() == 1).all()
    assert 0 < changed_clip("colour/denormal")["color"].max() < torch.finfo(torch.float32).tiny
    ranged = changed_clip("colour/out of range")["color"]
    assert ranged.min() < 0
    assert ranged.max() > 1
    assert changed_clip("hdr/1e-8")["radiance"].max() < 1e-7
    assert changed_clip("hdr/65504")["radiance"].max() == torch.finfo(torch.float16).max
    assert changed_clip("hdr/1e6")["radiance"].half().isinf().all()
    wide = changed_clip("hdr/1e-8 to 65504")["radiance"]
    assert wide.min().item() == pytest.approx(1e-8)
    assert wide.max().item() == pytest.approx(65504)
    assert changed_clip("hdr/infinite")["radiance"].isinf().all()
    assert changed_clip("hdr/infinite")["target_radiance"].isfinite().all()


def test_demodulation():
    assert changed_clip("demodulation/F_beta 0")["material"].abs().max() == 0
    assert changed_clip("demodulation/F_beta 0")["radiance"].min() > 0
    least, below = changed_clip("demodulation/F_beta least"), changed_clip("demodulation/F_beta below")
    assert least["material"].min() == MIN_MATERIAL
    assert 0 < below["material"].max() < MIN_MATERIAL
    lighting = demodulate(least["radiance"], least["material"], least["emission"])
    assert torch.allclose(lighting, torch.ones_like(lighting), atol=1e-9)
    assert demodulate(below["radiance"], below["material"], below["emission"]).abs().max() == 0
    bright = changed_clip("demodulation/F_beta small and lit")
    assert demodulate(bright["radiance"], bright["material"], bright["emission"]).max() > 1e3
    mirror, grazing = (
        changed_clip("demodulation/roughness 0")["material"],
        changed_clip("demodulation/grazing")["material"],
    )
    # F_0 times the masking of equation 9 on both sides, k = 1/8.
    assert mirror.mean().item() == pytest.approx(0.9 * (0.5 / (0.5 * 7 / 8 + 1 / 8)) ** 2, rel=0.02)
    assert grazing.isfinite().all()
    assert grazing.min() > 0.5
    black = changed_clip("demodulation/black smooth grazing")["material"]
    assert 0.0 < black.max() <= 1.0


def test_depths():
    assert changed_clip("depth/0")["depth"].max() == 0
    assert changed_clip("depth/1")["depth"].min() == 1
    assert changed_clip("depth/infinite")["depth"].isinf().all()
    assert changed_clip("depth/equal")["depth"].unique().numel() == 1
    plain, reverse = make_clip(ALL, 3, W, H, SCALE)["depth"], changed_clip("depth/reversed")["depth"]
    assert torch.equal(plain.flatten().argmax(), reverse.flatten().argmin())
    assert changed_clip("depth/reversed and infinite")["depth"].isinf().sum() == 3


@pytest.mark.parametrize(
    ("name", "x", "y"), [("zero", 0, 0), ("half a pixel", 0.5, 0.5), ("one pixel", 1, 1), ("many screens", 800, -480)]
)
def test_motions(name, x, y):
    motion = changed_clip(f"motion/{name}")["motion"]
    assert torch.allclose(motion[:, :, 0] * W, torch.tensor(float(x), dtype=torch.float64))
    assert torch.allclose(motion[:, :, 1] * H, torch.tensor(float(y), dtype=torch.float64))


def test_invalid_motions():
    assert changed_clip("motion/NaN")["motion"].isnan().all()
    assert changed_clip("motion/infinite")["motion_dual"].isinf().all()
    assert changed_clip("motion/1e30")["motion"].float().isfinite().all()
    motion = changed_clip("motion/discontinuous")["motion"]
    assert (motion.diff(dim=-1).abs() == 0.5).all()


def test_jitters():
    assert changed_clip("jitter/-0.5")["jitter"].min() == -0.5
    assert changed_clip("jitter/below 0.5")["jitter"].float().max() == torch.nextafter(
        torch.tensor(0.5), torch.tensor(0.0)
    )
    assert changed_clip("jitter/0.5")["jitter"].max() == 0.5
    assert changed_clip("jitter/3")["jitter"].abs().min() == 3
    assert changed_clip("jitter/NaN")["jitter"].isnan().all()
