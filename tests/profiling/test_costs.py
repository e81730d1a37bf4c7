"""Measured variants, their clips, and the reasons of missing variants."""

import pytest
import torch
import torch.nn.functional as F

from supersampling.errors import UserError
from supersampling.metrics.prepare import Continuous
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Backend, Eager
from supersampling.profiling.costs import measure


class Network(Upsampler):
    scale = 4
    requires = frozenset({"color"})

    def __init__(self):
        super().__init__()
        torch.manual_seed(0)
        self.layer = torch.nn.Conv2d(3, 3, 3, padding=1)

    def forward(self, frame, state):
        return F.interpolate(self.layer(frame.color).sigmoid(), scale_factor=4.0), torch.zeros(1)


class Absent(Backend):
    name = "absent"

    def missing(self, device, precision):
        return "It is not installed."

    def load(self, model, setting):
        raise AssertionError


class Failing(Absent):
    name = "failing"

    def missing(self, device, precision):
        return ""

    def load(self, model, setting):
        raise RuntimeError("no such kernel\nand more")


def test_variants_are_measured_or_have_a_reason(make_file, tmp_path):
    file = make_file(tmp_path, "test", clips=2, frames=3)
    model = Network().to(memory_format=torch.channels_last)
    before = [p.clone() for p in model.parameters()]
    combinations = [(Eager(), "float32"), (Absent(), "bfloat16"), (Failing(), "float16")]
    rows, reasons = measure(model, combinations, [file], Continuous(), None, 1)
    assert reasons == {("absent", "bfloat16"): "It is not installed.", ("failing", "float16"): "no such kernel"}
    assert list(rows["frame"]) == [0, 1, 2]  # of the scene's first clip
    assert list(rows["changed"]) == pytest.approx(list(rows["psnr"]), abs=1e-4)
    assert rows["machine"].nunique() == 1
    assert all(torch.equal(a, b) for a, b in zip(before, model.parameters()))
    all_rows, _ = measure(model, combinations[:1], [file], Continuous(), None, 1, all_clips=True)
    assert len(all_rows) == 6


def test_files_of_several_sizes_are_an_error(make_file, tmp_path):
    files = [make_file(tmp_path, "test"), make_file(tmp_path, "val", size=32)]
    with pytest.raises(UserError, match="12x12.*8x8"):
        measure(Network(), [(Eager(), "float32")], files, Continuous(), None, 1)
