"""What a precision changes, of a method with errors that are known, and of rounding that is real."""

import json

import numpy as np
import pandas as pd
import pytest
import torch
import torch.nn.functional as F

from supersampling.data.clips import WholeClips
from supersampling.frames import Frame
from supersampling.metrics.prepare import Continuous
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Eager, Setting
from supersampling.profiling.drift import calibration, first_clips, roll
from supersampling.runs.drift import KEYS, changes, costs, slope


class Repeat(Upsampler):
    """The input's pixels, and how many frames there were."""

    scale = 4
    requires = frozenset({"color"})

    def forward(self, frame, state):
        return F.interpolate(frame.color, scale_factor=4.0), torch.zeros(1) if state is None else state + 1


class Worse:
    """`Repeat` with ``error`` more on every pixel after each frame: a player of its own."""

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


def test_a_known_drift_is_found(clips):
    rows = roll(Repeat(), {("worse", "int8"): Worse(0.02), ("same", "float32"): Worse(0.0)}, clips, Continuous())
    assert len(rows) == 2 * 2 * 6
    worse, same = changes(named(rows))
    assert worse.largest == pytest.approx(0.1, abs=1e-6)  # 5 frames after the first; a new clip begins anew
    assert worse.frames == 12
    assert (same.mean.mean, same.slope.mean, same.largest) == (0.0, 0.0, 0.0)
    truth = []
    for index in range(2):
        apart = []
        for t, parts in enumerate(clips.read_frames(index)):
            image = F.interpolate(parts["color"], scale_factor=4.0).numpy()
            target = parts["target"].numpy()
            shown = np.clip(image + np.float32(0.02 * t), 0, 1)
            apart.append(10 * np.log10(((image - target) ** 2).mean() / ((shown - target) ** 2).mean()))
        truth.append(apart)
    assert worse.mean.mean == pytest.approx(np.mean(truth), abs=1e-4)
    assert worse.slope.mean == pytest.approx(np.mean([np.polyfit(range(6), a, 1)[0] for a in truth]), abs=1e-4)
    assert worse.slope.mean < -0.1
    assert costs([worse])["R", "worse", "int8"] == worse.mean


def test_what_is_not_finite_is_the_worst(clips):
    rows = roll(Repeat(), {("worse", "int8"): Worse(float("nan"))}, clips, Continuous(), [0])
    (change,) = changes(named(rows))
    assert change.largest == float("inf")
    assert change.mean.mean < -5
    assert np.isfinite(rows["changed"]).all()
    assert sorted(rows["clip"].unique()) == [0]


def test_rounding_is_small_and_there(clips):
    torch.manual_seed(0)

    class Network(Repeat):
        def __init__(self):
            super().__init__()
            self.layer = torch.nn.Conv2d(3, 3, 3, padding=1)

        def forward(self, frame, state):
            return F.interpolate(self.layer(frame.color).sigmoid(), scale_factor=4.0), torch.zeros(1)

    model = Network()
    setting = Setting(12, 12, "bfloat16", torch.device("cpu"), 1)
    exact = Setting(12, 12, "float32", torch.device("cpu"), 1)
    players = {
        ("eager", "bfloat16"): Eager().load(model, setting),
        ("eager", "float32"): Eager().load(model, exact),
    }
    coarse, fine = changes(named(roll(model, players, clips, Continuous(), first_clips(clips))))
    assert fine.largest == 0.0
    assert 1e-5 < coarse.largest < 0.02
    assert abs(coarse.mean.mean) < 0.05


def test_slope():
    x = pd.Series([0, 1, 2, 3, 7])
    assert slope(x, 3.0 - 0.25 * x) == pytest.approx(-0.25)
    assert slope(pd.Series([4]), pd.Series([1.0])) == 0.0


def test_frames_to_calibrate_on_fill_the_size(make_file, tmp_path):
    files = [make_file(tmp_path, "val", frames=4), make_file(tmp_path, "test", frames=3)]
    found = [list(clip) for clip in calibration(files, Repeat(), (20, 9), frames=3)]
    assert [len(clip) for clip in found] == [3, 3]
    assert {tuple(frame.color.shape) for clip in found for frame in clip} == {(1, 3, 9, 20)}


def test_a_table_read_back_from_json_gives_the_same(clips):
    rows = named(roll(Repeat(), {("worse", "int8"): Worse(0.02)}, clips, Continuous()))
    raw = json.loads(rows.to_json(orient="split"))
    again = pd.DataFrame(raw["data"], columns=raw["columns"])
    assert list(again.columns) == list(rows.columns)
    assert set(KEYS) <= set(again.columns)
    ours, theirs = changes(rows)[0], changes(again)[0]
    assert theirs.mean.mean == pytest.approx(ours.mean.mean)
    assert theirs.largest == pytest.approx(ours.largest)
