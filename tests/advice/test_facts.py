"""What a scene has and what follows: against data whose answer is known, and against what the pruned stages compute."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from advice_files import SCALE, write_file
from numpy.typing import NDArray

from supersampling.advice.facts import Fact, measure
from supersampling.advice.prior import prune, within
from supersampling.advice.space import Rule, Space, Switch
from supersampling.frames import Frame
from supersampling.ops.demodulate import demodulate
from supersampling.stages.motion_mask import DualMotionMask

T, H, W = 3, 8, 8
Clip = dict[str, NDArray[np.float32]]


def clip(**more: NDArray[np.float32]) -> Clip:
    rng = np.random.default_rng(0)
    made: Clip = {
        "color": np.round(rng.random((T, H, W, 3)) * 255).astype(np.float32) / 255,
        "motion": np.zeros((T, H, W, 2), np.float32),
        "motion_dual": np.zeros((T, H, W, 2), np.float32),
        "depth": np.full((T, H, W, 1), 0.5, np.float32),
        "jitter": np.zeros((T, 2), np.float32),
        "high_material": np.full((T, H * SCALE, W * SCALE, 3), 0.5, np.float32),
        "target": np.zeros((T, H * SCALE, W * SCALE, 3), np.float32),
    }
    return made | more


@pytest.fixture
def facts(tmp_path: Path) -> Callable[[Clip], dict[str, Fact]]:
    def of(one: Clip) -> dict[str, Fact]:
        return measure([write_file(tmp_path, "test", [one])], ["made"])

    return of


def test_a_dull_scene(facts: Callable[[Clip], dict[str, Fact]]) -> None:
    found = {name: fact.value for name, fact in facts(clip()).items()}
    assert found["largest_motion"] == found["dual_pixels"] == found["dilated_pixels"] == 0
    assert found["textured_pixels"] == found["sky_pixels"] == 0
    assert found["standing_pixels"] == found["new_frames"] == found["jitters"] == 1


def test_each_number_is_counted(facts: Callable[[Clip], dict[str, Fact]]) -> None:
    one = clip()
    one["motion"][1, 2, 3] = (0.25, 0.0)  # a quarter of 32 target pixels
    one["motion_dual"] = one["motion"].copy()
    one["motion_dual"][2, 5, 5] += (0.0, 0.2 / H)  # a fifth of a rendered pixel
    one["motion_dual"][2, 6, 6] += (0.0, 0.05 / H)  # too little for the mask
    one["depth"][1, 2, 3] = 0.25  # nearer than its neighbours, which take its motion
    one["depth"][:, 0] = 1.0
    one["high_material"][0, 0, 0] = 0.9  # within one rendered pixel
    one["high_material"][:, -SCALE:] = 0.0  # sky counts for nothing
    one["color"][2] = one["color"][1]
    one["jitter"][1] = 0.25
    found = {name: fact.value for name, fact in facts(one).items()}
    pixels = T * H * W
    assert found["largest_motion"] == pytest.approx(8.0)
    assert found["standing_pixels"] == pytest.approx(1 - 1 / pixels)
    assert found["dual_pixels"] == pytest.approx(1 / pixels)
    assert found["dilated_pixels"] == pytest.approx(8 / pixels)
    assert found["sky_pixels"] == pytest.approx(1 / H)
    assert found["textured_pixels"] == pytest.approx(1 / (T * (H - 1) * W))
    assert found["new_frames"] == 0.5
    assert found["jitters"] == 2


def test_files_that_lack_a_buffer_leave_the_fact_out(tmp_path: Path) -> None:
    one = clip()
    del one["motion_dual"]
    found = measure([write_file(tmp_path, "test", [one]), write_file(tmp_path, "val", [clip()])], ["made"])
    assert "dual_pixels" not in found
    assert "dilated_pixels" in found


def test_a_manifest_fills_in(tmp_path: Path) -> None:
    found = measure([write_file(tmp_path, "test", [clip()])], ["sundial"])
    assert (found["moving_pixels"].value, found["moving_pixels"].source) == (0.0, "manifest")


RULE = Rule("dual_pixels", 0.0, "the mask is empty")
SPACE = Space(
    "made",
    ("model=nsrd",),
    (Switch("mask", {"dual": ("m=dual",), "none": ("m=none",)}, (RULE,)), Switch("other", {"a": ("o=a",), "b": ("o=b",)})),
)  # fmt: skip


@pytest.mark.parametrize(
    ("fact", "left"),
    [
        (Fact(0.0, "files", ""), ["none"]),
        (Fact(0.01, "files", ""), ["dual", "none"]),
        (Fact(0.0, "manifest", ""), ["dual", "none"]),  # words are no check
        (None, ["dual", "none"]),
    ],
)
def test_only_what_the_files_show_is_left_out(fact: Fact | None, left: list[str]) -> None:
    space, reasons = prune(SPACE, {} if fact is None else {"dual_pixels": fact})
    assert list(space.switches[0].options) == left
    assert list(space.switches[1].options) == ["a", "b"]
    assert [r.tried for r in reasons] == [len(left) > 1, True]


def test_options_that_read_what_a_capture_lacks_are_left_out() -> None:
    def reads(composition):
        return frozenset({"color"} | ({"motion_dual"} if composition.options["mask"] == "dual" else set()))

    space, reasons = within(SPACE, frozenset({"color"}), reads)
    assert list(space.switches[0].options) == ["none"]
    assert "motion_dual" in reasons[0].why
    assert within(SPACE, frozenset({"color", "motion_dual"}), reads) == (SPACE, [])


def test_the_mask_of_equal_vectors_is_empty() -> None:
    """What the rule of the motion mask says, of the stage itself."""
    motion = torch.randn(1, 2, H, W) * 0.05
    stage = DualMotionMask()
    masked = stage(torch.zeros(1, 3, H, W), stage.vectors(Frame(motion=motion, motion_dual=motion.clone())))
    assert (masked[:, 3:] == 0).all()


def test_dividing_by_a_constant_changes_nothing_but_the_scale() -> None:
    """What the rule of demodulation says, of the operation itself."""
    radiance = torch.rand(1, 3, H, W) + 0.1
    material = torch.full((1, 3, H, W), 0.25)
    lighting = demodulate(radiance, material, torch.zeros_like(radiance))
    torch.testing.assert_close(lighting * 0.25, radiance)
