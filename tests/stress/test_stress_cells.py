"""Verdicts, and models that are broken on purpose: each is detected by the cell for its fault."""

import math

import pytest
import torch
import torch.nn.functional as F
from torch import nn

from supersampling.models.base import Upsampler
from supersampling.stress import quantised
from supersampling.stress.cell import Cell, fit_drift, judge, make_table, summarise
from supersampling.stress.determinism import determinism_cells
from supersampling.stress.extreme import Extreme
from supersampling.stress.loss import loss_cells
from supersampling.stress.plan import EXTREMES
from supersampling.stress.precision import PRECISIONS
from supersampling.stress.recovery import count_until, decreases, recovery_cells
from supersampling.stress.rollout import rollout_cells
from supersampling.stress.trial import extreme_cells

BY_NAME = {extreme.name: extreme for extreme in EXTREMES}
SIZE = 6, 5


class Plain(Upsampler):
    """A sound model of nearest-neighbour colour, which the subclasses break."""

    requires = frozenset({"color", "motion"})

    def __init__(self, scale=2):
        super().__init__()
        self.scale = scale
        self.conv = nn.Conv2d(3, 3, 1)
        nn.init.dirac_(self.conv.weight)
        nn.init.zeros_(self.conv.bias)

    def filter(self, frame, state):
        return self.conv(frame.color)

    def forward(self, frame, state):
        low = self.filter(frame, state).to(frame.color.dtype)
        output = F.interpolate(low, scale_factor=self.scale)
        return output, output


class Division(Plain):
    """A division by the sum of all colours."""

    def filter(self, frame, state):
        return self.conv(frame.color) / frame.color.sum(dim=(1, 2, 3), keepdim=True)


class Overflow(Plain):
    """Intermediate values beyond float16."""

    def filter(self, frame, state):
        return self.conv(self.conv(frame.color) * 1e6) / 1e6


class Persistent(Plain):
    """Half of the previous output, even if it is not finite."""

    def filter(self, frame, state):
        now = self.conv(frame.color)
        return now if state is None else 0.5 * now + 0.5 * state[..., :: self.scale, :: self.scale]


class Drifting(Plain):
    """A constant error per frame, in float32 only."""

    def filter(self, frame, state):
        step = 1e-4 if frame.color.dtype == torch.float32 else 0.0
        return frame.color if state is None else state[..., :: self.scale, :: self.scale] + step


class Random(Plain):
    """Noise that differs from call to call."""

    def filter(self, frame, state):
        return frame.color + 1e-3 * torch.rand_like(frame.color)


class Root(Plain):
    """A square root, whose derivative is infinite at a black pixel."""

    def filter(self, frame, state):
        return self.conv(frame.color).sqrt()


class BatchMean(Plain):
    """A mean over the batch, so that its items influence each other."""

    def filter(self, frame, state):
        return frame.color - frame.color.mean(dim=0, keepdim=True) + 0.5


def cells(model, extreme, *names):
    return {
        c.precision: c for c in extreme_cells("m", model, BY_NAME[extreme], [PRECISIONS[n] for n in names], SIZE, "cpu")
    }


def test_sound_model_holds():
    for name in ("colour/black", "colour/white", "motion/NaN", "size/1x1"):
        for cell in cells(Plain(), name, "float32", "bfloat16", "float16").values():
            assert cell.verdict == "holds", cell
            assert cell.gradient == "finite"


def test_division_by_zero_is_detected_on_black():
    cell = cells(Division(), "colour/black", "float32")["float32"]
    assert not cell.finite
    assert cell.verdict == "fails"
    assert cell.reason == "not finite"
    assert cells(Division(), "colour/white", "float32")["float32"].verdict == "holds"


def test_overflow_of_float16_is_detected_in_float16_only():
    tried = cells(Overflow(), "colour/white", "float32", "bfloat16", "float16")
    assert [tried[p].verdict for p in ("float32", "bfloat16", "float16")] == ["holds", "holds", "fails"]
    assert not tried["float16"].finite


def test_infinite_gradient_is_detected():
    cell = cells(Root(), "colour/black", "float32")["float32"]
    assert cell.finite
    assert cell.gradient == "not finite"
    assert cell.verdict == "fails"


def test_persistent_state_is_detected_and_a_sound_model_recovers():
    persistent = {c.extreme: c for c in recovery_cells("m", Persistent(), SIZE, 24, "cpu")}
    assert persistent["recovery/state NaN"].verdict == "fails"
    assert persistent["recovery/state NaN"].reason == "not finite after 24 frames"
    # The repaired bad frame contributes black to one half, and that error halves in every frame.
    cell = persistent["recovery/color NaN"]
    assert cell.value == math.ceil(math.log2(cell.largest * 510))
    clean = {c.extreme: c for c in recovery_cells("m", Plain(), SIZE, 4, "cpu")}
    assert clean["recovery/state NaN"].value == 0
    assert clean["recovery/color NaN"].value == 1
    assert clean["recovery/motion NaN"].value == 0
    assert {c.verdict for c in clean.values()} == {"holds"}


def test_drift_is_the_error_added_per_frame():
    (static, moving) = rollout_cells("m", Drifting(), [PRECISIONS["float32"]], SIZE, [200], "cpu")
    for cell in (static, moving):
        # The first frame is shown without end in both precisions, so that only the added error differs.
        assert cell.drift == pytest.approx(1e-4, rel=0.01)
        assert cell.verdict == "fails"
        assert cell.value == pytest.approx(1e-4 * 189.5, rel=0.01)


def test_determinism_detects_noise_and_a_batch_mean():
    noisy = {c.extreme: c for c in determinism_cells("m", Random(), SIZE, "cpu")}
    assert noisy["determinism/repeated"].verdict == "fails"
    mixed = {c.extreme: c for c in determinism_cells("m", BatchMean(), SIZE, "cpu")}
    assert mixed["determinism/repeated"].verdict == "holds"
    assert mixed["determinism/batch"].verdict == "fails"
    assert {c.verdict for c in determinism_cells("m", Plain(), SIZE, "cpu")} == {"holds"}


def test_ends_of_theta():
    tried = list(loss_cells("m", Plain(), [PRECISIONS["float32"]], SIZE, "cpu"))
    assert [c.extreme for c in tried] == ["theta/0", "theta/0.999", "theta/1"]
    assert {c.verdict for c in tried} == {"holds"}
    # 0.001 of the spatial and 0.999 of the temporal loss (equation 54).
    spatial, mixed, temporal = (c.truth for c in tried)
    assert mixed == pytest.approx(0.001 * spatial + 0.999 * temporal, rel=1e-9)


def test_cells_that_are_not_tried_have_a_reason(monkeypatch):
    monkeypatch.setattr(quantised, "explain_missing", lambda name, device: f"{device} has no {name}")
    extremes = [BY_NAME[n] for n in ("colour/white", "gate/o1 0", "hdr/1e6", "scale/3")]
    tried = list(quantised.int8_cells("m", Plain(), extremes, SIZE))
    assert [c.extreme for c in tried] == ["colour/white", "scale/3"]
    assert {(c.verdict, c.reason, c.precision) for c in tried} == {("not tried", "cpu has no int8", "int8")}
    (cell,) = extreme_cells("m", Plain(), BY_NAME["size/8K input"], [PRECISIONS["float32"]], SIZE, "cpu", "too large")
    assert (cell.verdict, cell.reason, cell.size) == ("not tried", "too large", "7680x4320")


def test_extreme_that_does_not_concern_a_model_has_no_cell():
    assert not cells(Plain(), "hdr/65504", "float32")
    assert not cells(Plain(), "gate/o1 0", "float32")
    assert not list(extreme_cells("m", Plain(), Extreme("x/y", "", adjust=lambda m: False), [], SIZE, "cpu"))


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


def test_drift_recovery_and_summary():
    assert fit_drift([1.0, 3.0, 5.0]) == pytest.approx(2.0)
    assert math.isnan(fit_drift([1.0]))
    assert math.isnan(fit_drift([1.0, math.inf]))
    assert count_until([True, True]) == 0
    assert count_until([False, True, False, True]) == 3
    assert math.isnan(count_until([True, False]))
    assert decreases([8, 8, 4, 2])
    assert not decreases([8, 4, 2, 2])
    cell = Cell(model="m", extreme="e", precision="float32", size="1x1", scale=1, frames=1)
    assert summarise([cell]) == "0 cells hold, 0 fail, 1 were not tried"
    assert list(make_table([cell]).columns)[:3] == ["model", "extreme", "precision"]
