"""Verdicts, and models that are broken on purpose: each is caught by the cell that looks for it."""

import math

import pytest
import torch
import torch.nn.functional as F
from torch import nn

from supersampling.models.base import Upsampler
from supersampling.stress import quantised
from supersampling.stress.cell import Cell, drift_of, frame_of_cells, judge, summary
from supersampling.stress.determinism import determinism_cells
from supersampling.stress.extreme import Extreme
from supersampling.stress.loss import loss_cells
from supersampling.stress.plan import EXTREMES
from supersampling.stress.precision import PRECISIONS
from supersampling.stress.recovery import frames_until, nears, recovery_cells
from supersampling.stress.rollout import rollout_cells
from supersampling.stress.trial import cells_of

BY_NAME = {extreme.name: extreme for extreme in EXTREMES}
SIZE = 6, 5


class Plain(Upsampler):
    """Nearest-neighbour colour; what is broken of it comes in subclasses."""

    requires = frozenset({"color", "motion"})

    def __init__(self, scale=2):
        super().__init__()
        self.scale = scale
        self.conv = nn.Conv2d(3, 3, 1)
        nn.init.dirac_(self.conv.weight)
        nn.init.zeros_(self.conv.bias)

    def made(self, frame, state):
        return self.conv(frame.color)

    def forward(self, frame, state):
        made = self.made(frame, state).to(frame.color.dtype)
        output = F.interpolate(made, scale_factor=self.scale)
        return output, output


class Divides(Plain):
    """By the sum of all colours."""

    def made(self, frame, state):
        return self.conv(frame.color) / frame.color.sum(dim=(1, 2, 3), keepdim=True)


class Overflows(Plain):
    """Beyond float16 in between, and back."""

    def made(self, frame, state):
        return self.conv(self.conv(frame.color) * 1e6) / 1e6


class Poisoned(Plain):
    """Half of the last output, whatever it was."""

    def made(self, frame, state):
        now = self.conv(frame.color)
        return now if state is None else 0.5 * now + 0.5 * state[..., :: self.scale, :: self.scale]


class Adds(Plain):
    """A rounding step a frame, of float32 alone."""

    def made(self, frame, state):
        step = 1e-4 if frame.color.dtype == torch.float32 else 0.0
        return frame.color if state is None else state[..., :: self.scale, :: self.scale] + step


class Random(Plain):
    def made(self, frame, state):
        return frame.color + 1e-3 * torch.rand_like(frame.color)


class Rooted(Plain):
    """The root of a black pixel has no finite derivative."""

    def made(self, frame, state):
        return self.conv(frame.color).sqrt()


class Mixes(Plain):
    """Items of a batch see each other."""

    def made(self, frame, state):
        return frame.color - frame.color.mean(dim=0, keepdim=True) + 0.5


def cells(model, extreme, *names):
    return {c.precision: c for c in cells_of("m", model, BY_NAME[extreme], [PRECISIONS[n] for n in names], SIZE, "cpu")}


def test_a_plain_model_holds():
    for name in ("colour/black", "colour/white", "motion/NaN", "size/1x1"):
        for cell in cells(Plain(), name, "float32", "bfloat16", "float16").values():
            assert cell.verdict == "holds", cell
            assert cell.gradient == "finite"


def test_a_division_by_zero_is_caught_where_all_is_black():
    cell = cells(Divides(), "colour/black", "float32")["float32"]
    assert not cell.finite
    assert cell.verdict == "fails"
    assert cell.why == "not finite"
    assert cells(Divides(), "colour/white", "float32")["float32"].verdict == "holds"


def test_an_overflow_of_float16_is_caught_there_alone():
    found = cells(Overflows(), "colour/white", "float32", "bfloat16", "float16")
    assert [found[p].verdict for p in ("float32", "bfloat16", "float16")] == ["holds", "holds", "fails"]
    assert not found["float16"].finite


def test_an_infinite_gradient_is_caught():
    cell = cells(Rooted(), "colour/black", "float32")["float32"]
    assert cell.finite
    assert cell.gradient == "not finite"
    assert cell.verdict == "fails"


def test_a_poisoned_state_is_caught_and_a_clean_one_forgets():
    poisoned = {c.extreme: c for c in recovery_cells("m", Poisoned(), SIZE, 24, "cpu")}
    assert poisoned["recovery/state NaN"].verdict == "fails"
    assert poisoned["recovery/state NaN"].why == "not finite after 24 frames"
    # A mended bad frame is black on its half, and half of that goes in every frame.
    cell = poisoned["recovery/color NaN"]
    assert cell.value == math.ceil(math.log2(cell.largest * 510))
    clean = {c.extreme: c for c in recovery_cells("m", Plain(), SIZE, 4, "cpu")}
    assert clean["recovery/state NaN"].value == 0
    assert clean["recovery/color NaN"].value == 1
    assert clean["recovery/motion NaN"].value == 0
    assert {c.verdict for c in clean.values()} == {"holds"}


def test_drift_is_what_is_added_a_frame():
    (still, moving) = rollout_cells("m", Adds(), [PRECISIONS["float32"]], SIZE, [200], "cpu")
    for cell in (still, moving):
        # Two of three axes' noise away: the first frame is shown for ever, in both precisions.
        assert cell.drift == pytest.approx(1e-4, rel=0.01)
        assert cell.verdict == "fails"
        assert cell.value == pytest.approx(1e-4 * 189.5, rel=0.01)


def test_determinism_tells_noise_and_a_batch_that_mixes():
    noisy = {c.extreme: c for c in determinism_cells("m", Random(), SIZE, "cpu")}
    assert noisy["determinism/repeated"].verdict == "fails"
    mixed = {c.extreme: c for c in determinism_cells("m", Mixes(), SIZE, "cpu")}
    assert mixed["determinism/repeated"].verdict == "holds"
    assert mixed["determinism/batch"].verdict == "fails"
    assert {c.verdict for c in determinism_cells("m", Plain(), SIZE, "cpu")} == {"holds"}


def test_theta_at_its_ends():
    found = list(loss_cells("m", Plain(), [PRECISIONS["float32"]], SIZE, "cpu"))
    assert [c.extreme for c in found] == ["theta/0", "theta/0.999", "theta/1"]
    assert {c.verdict for c in found} == {"holds"}
    # 0.001 of the spatial and 0.999 of the temporal one (equation 54).
    spatial, mixed, temporal = (c.truth for c in found)
    assert mixed == pytest.approx(0.001 * spatial + 0.999 * temporal, rel=1e-9)


def test_int8_and_what_does_not_fit_say_why(monkeypatch):
    monkeypatch.setattr(quantised, "lacks", lambda name, device: f"{device} has no {name}")
    extremes = [BY_NAME[n] for n in ("colour/white", "gate/o1 0", "hdr/1e6", "scale/3")]
    found = list(quantised.int8_cells("m", Plain(), extremes, SIZE))
    assert [c.extreme for c in found] == ["colour/white", "scale/3"]
    assert {(c.verdict, c.why, c.precision) for c in found} == {("not tried", "cpu has no int8", "int8")}
    (cell,) = cells_of("m", Plain(), BY_NAME["size/8K input"], [PRECISIONS["float32"]], SIZE, "cpu", "too large")
    assert (cell.verdict, cell.why, cell.size) == ("not tried", "too large", "7680x4320")


def test_an_extreme_that_does_not_concern_a_model_has_no_cell():
    assert not cells(Plain(), "hdr/65504", "float32")
    assert not cells(Plain(), "gate/o1 0", "float32")
    assert not list(cells_of("m", Plain(), Extreme("x/y", "", adjust=lambda m: False), [], SIZE, "cpu"))


@pytest.mark.parametrize(
    ("finite", "largest", "mean", "gradient", "verdict", "why"),
    [
        (True, 0.1, 0.01, "finite", "holds", ""),
        (True, 0.1, 0.01, "", "holds", ""),
        (False, 0.1, 0.01, "", "fails", "not finite"),
        (True, 0.11, 0.01, "", "fails", "largest error 0.11 above 0.1"),
        (True, 0.1, 0.02, "", "fails", "mean error 0.02 above 0.01"),
        (True, math.nan, 0.0, "", "fails", "largest error nan above 0.1"),
        (True, 0.0, 0.0, "not finite", "fails", "gradients are not finite"),
    ],
)
def test_verdicts(finite, largest, mean, gradient, verdict, why):
    assert judge(finite, largest, mean, gradient, (0.1, 0.01)) == (verdict, why)


def test_small_numbers():
    assert drift_of([1.0, 3.0, 5.0]) == pytest.approx(2.0)
    assert math.isnan(drift_of([1.0]))
    assert math.isnan(drift_of([1.0, math.inf]))
    assert frames_until([True, True]) == 0
    assert frames_until([False, True, False, True]) == 3
    assert math.isnan(frames_until([True, False]))
    assert nears([8, 8, 4, 2])
    assert not nears([8, 4, 2, 2])
    one = Cell("m", "e", "float32", "1x1", 1, 1)
    assert summary([one]) == "0 cells hold, 0 fail, 1 were not tried"
    assert list(frame_of_cells([one]).columns)[:3] == ["model", "extreme", "precision"]
