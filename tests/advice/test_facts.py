"""Facts of a scene and the pruning of switches: on data with known facts, and against the pruned stages."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from advice_files import SCALE, write_file
from numpy.typing import NDArray

from supersampling.advice.facts import Fact, measure_facts
from supersampling.advice.prior import prune, restrict_to_buffers
from supersampling.advice.space import Rule, Space, Switch
from supersampling.frames import Frame
from supersampling.ops.demodulate import demodulate
from supersampling.stages.motion_mask import DualMotionMask

T, H, W = 3, 8, 8
Clip = dict[str, NDArray[np.float32]]


def clip(**more: NDArray[np.float32]) -> Clip:
    rng = np.random.default_rng(0)
    buffers: Clip = {
        "color": np.round(rng.random((T, H, W, 3)) * 255).astype(np.float32) / 255,
        "motion": np.zeros((T, H, W, 2), np.float32),
        "motion_dual": np.zeros((T, H, W, 2), np.float32),
        "depth": np.full((T, H, W, 1), 0.5, np.float32),
        "jitter": np.zeros((T, 2), np.float32),
        "high_material": np.full((T, H * SCALE, W * SCALE, 3), 0.5, np.float32),
        "target": np.zeros((T, H * SCALE, W * SCALE, 3), np.float32),
    }
    return buffers | more


@pytest.fixture
def facts(tmp_path: Path) -> Callable[[Clip], dict[str, Fact]]:
    def measure(clip: Clip) -> dict[str, Fact]:
        return measure_facts([write_file(tmp_path, "test", [clip])], ["synthetic"])

    return measure


def test_uniform_static_scene(facts: Callable[[Clip], dict[str, Fact]]) -> None:
    values = {name: fact.value for name, fact in facts(clip()).items()}
    assert values["largest_motion"] == values["dual_pixels"] == values["dilated_pixels"] == 0
    assert values["textured_pixels"] == values["sky_pixels"] == 0
    assert values["standing_pixels"] == values["new_frames"] == values["jitters"] == 1


def test_facts_of_single_pixels(facts: Callable[[Clip], dict[str, Fact]]) -> None:
    buffers = clip()
    buffers["motion"][1, 2, 3] = (0.25, 0.0)  # a quarter of 32 target pixels
    buffers["motion_dual"] = buffers["motion"].copy()
    buffers["motion_dual"][2, 5, 5] += (0.0, 0.2 / H)  # a fifth of a rendered pixel
    buffers["motion_dual"][2, 6, 6] += (0.0, 0.05 / H)  # too little for the mask
    buffers["depth"][1, 2, 3] = 0.25  # nearer than its neighbours, which take its motion
    buffers["depth"][:, 0] = 1.0
    buffers["high_material"][0, 0, 0] = 0.9  # within one rendered pixel
    buffers["high_material"][:, -SCALE:] = 0.0  # sky counts for nothing
    buffers["color"][2] = buffers["color"][1]
    buffers["jitter"][1] = 0.25
    values = {name: fact.value for name, fact in facts(buffers).items()}
    pixels = T * H * W
    assert values["largest_motion"] == pytest.approx(8.0)
    assert values["standing_pixels"] == pytest.approx(1 - 1 / pixels)
    assert values["dual_pixels"] == pytest.approx(1 / pixels)
    assert values["dilated_pixels"] == pytest.approx(8 / pixels)
    assert values["sky_pixels"] == pytest.approx(1 / H)
    assert values["textured_pixels"] == pytest.approx(1 / (T * (H - 1) * W))
    assert values["new_frames"] == 0.5
    assert values["jitters"] == 2


def test_fact_needs_its_buffers_in_all_files(tmp_path: Path) -> None:
    buffers = clip()
    del buffers["motion_dual"]
    measured = measure_facts(
        [write_file(tmp_path, "test", [buffers]), write_file(tmp_path, "val", [clip()])], ["synthetic"]
    )
    assert "dual_pixels" not in measured
    assert "dilated_pixels" in measured


def test_manifest_supplements_the_files(tmp_path: Path) -> None:
    measured = measure_facts([write_file(tmp_path, "test", [clip()])], ["sundial"])
    assert (measured["moving_pixels"].value, measured["moving_pixels"].source) == (0.0, "manifest")


RULE = Rule("dual_pixels", 0.0, "the mask is empty")
SPACE = Space(
    "synthetic",
    ("model=nsrd",),
    (
        Switch("mask", {"dual": ("m=dual",), "none": ("m=none",)}, (RULE,)),
        Switch("other", {"a": ("o=a",), "b": ("o=b",)}),
    ),
)


@pytest.mark.parametrize(
    ("fact", "options"),
    [
        (Fact(0.0, "files", ""), ["none"]),
        (Fact(0.01, "files", ""), ["dual", "none"]),
        (Fact(0.0, "manifest", ""), ["dual", "none"]),  # a manifest is no measurement of the files
        (None, ["dual", "none"]),
    ],
)
def test_only_facts_of_the_files_prune(fact: Fact | None, options: list[str]) -> None:
    space, reasons = prune(SPACE, {} if fact is None else {"dual_pixels": fact})
    assert list(space.switches[0].options) == options
    assert list(space.switches[1].options) == ["a", "b"]
    assert [r.searched for r in reasons] == [len(options) > 1, True]


def test_options_that_read_a_missing_buffer_are_removed() -> None:
    def buffers_of(composition):
        return frozenset({"color"} | ({"motion_dual"} if composition.options["mask"] == "dual" else set()))

    space, reasons = restrict_to_buffers(SPACE, frozenset({"color"}), buffers_of)
    assert list(space.switches[0].options) == ["none"]
    assert "motion_dual" in reasons[0].text
    assert restrict_to_buffers(SPACE, frozenset({"color", "motion_dual"}), buffers_of) == (SPACE, [])


def test_mask_of_equal_vectors_is_empty() -> None:
    """The rule of the motion mask holds for the stage itself."""
    motion = torch.randn(1, 2, H, W) * 0.05
    stage = DualMotionMask()
    masked = stage(torch.zeros(1, 3, H, W), stage.vectors(Frame(motion=motion, motion_dual=motion.clone())))
    assert (masked[:, 3:] == 0).all()


def test_division_by_a_constant_changes_the_scale_only() -> None:
    """The rule of demodulation holds for the operation itself."""
    radiance = torch.rand(1, 3, H, W) + 0.1
    material = torch.full((1, 3, H, W), 0.25)
    lighting = demodulate(radiance, material, torch.zeros_like(radiance))
    torch.testing.assert_close(lighting * 0.25, radiance)
