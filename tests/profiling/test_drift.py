"""Effect of a precision on quality, for a method of known errors and for real rounding."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import torch
import torch.nn.functional as F

from supersampling.data.clips import WholeClips
from supersampling.frames import Frame
from supersampling.metrics.prepare import Continuous
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Eager, LoadOptions
from supersampling.profiling.drift import calibration_clips, first_clips, roll
from supersampling.runs.drift import KEYS, changes, costs, slope


class Repeat(Upsampler):
    """A method that repeats the input's pixels; its state counts the frames."""

    scale = 4
    requires = frozenset({"color"})

    def forward(self, frame, state):
        return F.interpolate(frame.color, scale_factor=4.0), torch.zeros(1) if state is None else state + 1


class Worse:
    """A player of `Repeat` that adds ``error`` to all pixels after each frame."""

    def __init__(self, error: float) -> None:
        self._error, self._t = error, 0

    def reset(self) -> None:
        self._t = 0

    def prepare(self, frame: Frame) -> Frame:
        return frame

    def step(self, prepared: Frame) -> torch.Tensor:
        self._t += 1
        return F.interpolate(prepared.color, scale_factor=4.0) + self._error * (self._t - 1)

    def image(self, result: torch.Tensor) -> torch.Tensor:
        return result


@pytest.fixture(scope="module")
def clips(make_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("clips")
    return WholeClips([make_file(folder, "test", clips=2, frames=6)], frozenset({"color"}))


def named(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.assign(method="repeat", architecture="R", machine="m")


def test_known_drift(clips):
    rows = roll(Repeat(), {("worse", "int8"): Worse(0.02), ("same", "float32"): Worse(0.0)}, clips, Continuous())
    assert len(rows) == 2 * 2 * 6
    worse, same = changes(named(rows))
    assert worse.largest == pytest.approx(0.1, abs=1e-6)  # 5 frames after the first; each clip starts from 0
    assert worse.frames == 12
    assert (same.mean.mean, same.slope.mean, same.largest) == (0.0, 0.0, 0.0)
    truth = []
    for index in range(2):
        differences = []
        for t, parts in enumerate(clips.read_frames(index)):
            image = F.interpolate(parts["color"], scale_factor=4.0).numpy()
            target = parts["target"].numpy()
            shifted = np.clip(image + np.float32(0.02 * t), 0, 1)
            differences.append(10 * np.log10(((image - target) ** 2).mean() / ((shifted - target) ** 2).mean()))
        truth.append(differences)
    assert worse.mean.mean == pytest.approx(np.mean(truth), abs=1e-4)
    assert worse.slope.mean == pytest.approx(np.mean([np.polyfit(range(6), a, 1)[0] for a in truth]), abs=1e-4)
    assert worse.slope.mean < -0.1
    assert costs([worse])["R", "worse", "int8"] == worse.mean


def test_values_that_are_not_finite(clips):
    rows = roll(Repeat(), {("worse", "int8"): Worse(float("nan"))}, clips, Continuous(), [0])
    (change,) = changes(named(rows))
    assert change.largest == float("inf")
    assert change.mean.mean < -5
    assert np.isfinite(rows["changed"]).all()
    assert sorted(rows["clip"].unique()) == [0]


def test_rounding_is_small_but_not_zero(clips):
    torch.manual_seed(0)

    class Network(Repeat):
        def __init__(self):
            super().__init__()
            self.layer = torch.nn.Conv2d(3, 3, 3, padding=1)

        def forward(self, frame, state):
            return F.interpolate(self.layer(frame.color).sigmoid(), scale_factor=4.0), torch.zeros(1)

    model = Network()
    coarse_options = LoadOptions(width=12, height=12, precision="bfloat16", device=torch.device("cpu"), threads=1)
    players = {
        ("eager", "bfloat16"): Eager().load(model, coarse_options),
        ("eager", "float32"): Eager().load(model, replace(coarse_options, precision="float32")),
    }
    coarse, fine = changes(named(roll(model, players, clips, Continuous(), first_clips(clips))))
    assert fine.largest == 0.0
    assert 1e-5 < coarse.largest < 0.02
    assert abs(coarse.mean.mean) < 0.05


def test_slope():
    x = pd.Series([0, 1, 2, 3, 7])
    assert slope(x, 3.0 - 0.25 * x) == pytest.approx(-0.25)
    assert slope(pd.Series([4]), pd.Series([1.0])) == 0.0


def test_calibration_frames_fill_the_size(make_file, tmp_path):
    files = [make_file(tmp_path, "val", frames=4), make_file(tmp_path, "test", frames=3)]
    lists = [list(clip) for clip in calibration_clips(files, Repeat(), (20, 9), frames=3)]
    assert [len(clip) for clip in lists] == [3, 3]
    assert {tuple(frame.color.shape) for clip in lists for frame in clip} == {(1, 3, 9, 20)}


def test_table_from_json_gives_the_same_changes(clips):
    rows = named(roll(Repeat(), {("worse", "int8"): Worse(0.02)}, clips, Continuous()))
    raw = json.loads(rows.to_json(orient="split"))
    parsed = pd.DataFrame(raw["data"], columns=raw["columns"])
    assert list(parsed.columns) == list(rows.columns)
    assert set(KEYS) <= set(parsed.columns)
    first, second = changes(rows)[0], changes(parsed)[0]
    assert second.mean.mean == pytest.approx(first.mean.mean)
    assert second.largest == pytest.approx(first.largest)
