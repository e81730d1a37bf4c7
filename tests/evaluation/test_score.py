"""Scores of whole clips against a plain loop over arrays and scikit-image."""

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from PIL import Image
from skimage.metrics import peak_signal_noise_ratio

from supersampling.data.dataset_file import DatasetFile
from supersampling.errors import UserError
from supersampling.evaluation.crops import detailed_corner
from supersampling.evaluation.protocol import Protocol
from supersampling.evaluation.result import evaluate
from supersampling.metrics.prepare import Continuous, EightBit
from supersampling.metrics.scores import read_scores
from supersampling.metrics.selection import Metrics
from supersampling.metrics.still import PSNR
from supersampling.metrics.video.base import Scoring, VideoMetric
from supersampling.models.base import Upsampler
from supersampling.models.bicubic import Bicubic


class Count(VideoMetric):
    """The number of frames that the scoring of a clip received, and the mean of its targets."""

    names = ("seen", "brightness")

    def begin(self):
        return _Counting()


class _Counting(Scoring):
    def __init__(self):
        self.means = []

    def add(self, moment):
        self.means.append(moment.target.mean().item())

    def finish(self):
        return {"seen": float(len(self.means)), "brightness": float(np.mean(self.means))}


class CountsFrames(Upsampler):
    """Output: the number of previous frames of the clip divided by ten; the state starts again with each clip."""

    requires = frozenset({"color"})
    scale = 4

    def forward(self, frame, state):
        shape = (*frame.color.shape[:2], *(4 * n for n in frame.color.shape[-2:]))
        state = state or 0
        return torch.full(shape, state / 10), state + 1


@pytest.fixture
def path(make_file, tmp_path):
    return make_file(tmp_path, "test", clips=2, frames=5)


def expected_psnr(path, clip, frame, eight_bit=False):
    store = DatasetFile(path)
    part = slice(frame, frame + 1)
    color, target = (store.read(name, clip, part) for name in ("color", "target"))
    output = F.interpolate(torch.from_numpy(color), scale_factor=4, mode="bicubic").clamp(0, 1).numpy()
    if eight_bit:
        output = np.rint(output * 255) / 255
    return peak_signal_noise_ratio(target.astype(np.float64), output.astype(np.float64), data_range=1.0)


@pytest.mark.parametrize(("prepare", "eight_bit"), [(Continuous(), False), (EightBit(), True)])
def test_every_frame_of_every_clip_is_scored(path, prepare, eight_bit):
    result = evaluate(Bicubic(4), Metrics([PSNR()]), Protocol(prepare), [path])
    frames = result.frames.set_index(["clip", "frame"])["psnr"]
    expected = {(c, t): expected_psnr(path, c, t, eight_bit) for c in range(2) for t in range(5)}
    assert frames.to_dict() == pytest.approx(expected, abs=1e-4)
    by_clip = [np.mean([expected[c, t] for t in range(5)]) for c in range(2)]
    assert result.clips["psnr"].tolist() == pytest.approx(by_clip, abs=1e-4)
    assert result.summary()["test/psnr"] == pytest.approx(np.mean(by_clip), abs=1e-4)
    assert result.summary()["test/analytic/psnr"] == pytest.approx(np.mean(by_clip), abs=1e-4)


def test_warm_up_is_listed_but_enters_no_mean(path):
    result = evaluate(Bicubic(4), Metrics([PSNR()], [Count()]), Protocol(Continuous(), warm_up=2), [path])
    assert len(result.frames) == 10
    expected = [np.mean([expected_psnr(path, c, t) for t in range(2, 5)]) for c in range(2)]
    assert result.clips["psnr"].tolist() == pytest.approx(expected, abs=1e-4)
    assert result.clips["seen"].tolist() == [3.0, 3.0]
    target = DatasetFile(path).read("target", 1, slice(2, 5))
    assert result.clips["brightness"][1] == pytest.approx(target.mean(), abs=1e-5)


def test_state_is_carried_through_clip_and_not_to_the_next(path):
    result = evaluate(CountsFrames(), Metrics([PSNR()]), Protocol(Continuous()), [path])
    for clip in range(2):
        target = DatasetFile(path).read("target", clip, slice(0, 5)).astype(np.float64)
        expected = [-10 * np.log10(np.square(target[t] - t / 10).mean()) for t in range(5)]
        values = result.frames[result.frames["clip"] == clip]["psnr"]
        assert values.tolist() == pytest.approx(expected, abs=1e-4)


def test_border_is_left_out(path):
    result = evaluate(Bicubic(4), Metrics([PSNR()]), Protocol(Continuous(), border=3), [path])
    store = DatasetFile(path)
    color, target = (torch.from_numpy(store.read(n, 0, slice(0, 1))) for n in ("color", "target"))
    output = F.interpolate(color, scale_factor=4, mode="bicubic").clamp(0, 1)
    error = (output - target)[..., 12:-12, 12:-12].square().mean().item()
    assert result.frames["psnr"][0] == pytest.approx(-10 * np.log10(error), abs=1e-4)


def test_all_values_are_written_to_files(path, tmp_path):
    result = evaluate(Bicubic(4), Metrics([PSNR()], [Count()]), Protocol(Continuous()), [path])
    result.write(tmp_path)
    stored = read_scores(tmp_path / "frames.parquet")
    assert stored.frames["psnr"].tolist() == result.frames["psnr"].tolist()
    assert stored.clips[["psnr", "seen"]].equals(result.clips[["psnr", "seen"]])
    assert stored.scenes["seen"].tolist() == [5.0]
    assert (tmp_path / "crops.png").stat().st_size > 0
    crops = ["0_analytic.png", "0_analytic_input.png", "0_analytic_target.png"]
    assert sorted(p.name for p in (tmp_path / "crops").iterdir()) == crops
    with Image.open(tmp_path / "epipolar" / "0_analytic_target.png") as plane:
        rows = np.asarray(plane)
    target = DatasetFile(path).read("target", 0, slice(0, 5))[:, :, 24].transpose(0, 2, 1)
    np.testing.assert_allclose(rows, target * 255, atol=0.01)


class Pictured(Bicubic):
    """With a picture of its state: the row of the target position relative to the image's height."""

    def state_images(self, state):
        return {"rows": torch.linspace(0, 1, 48)[None, None, :, None].expand(1, 1, 48, 64)}


def test_state_picture_is_at_the_position_of_the_crop(path, tmp_path):
    evaluate(Pictured(4), Metrics([PSNR()]), Protocol(Continuous()), [path]).write(tmp_path)
    with Image.open(tmp_path / "state" / "0_analytic_rows.png") as picture:
        values = np.asarray(picture)
    with Image.open(tmp_path / "crops" / "0_analytic_target.png") as crop:
        assert picture.size == crop.size
    y, _ = detailed_corner(torch.from_numpy(DatasetFile(path).read("target", 0, slice(4, 5))), min(picture.size))
    expected = np.round(255 * np.linspace(0, 1, 48))[y : y + len(values), None, None]
    np.testing.assert_array_equal(values, np.broadcast_to(expected, values.shape))


def test_metrics_of_earlier_evaluation_are_kept(path, tmp_path):
    first = evaluate(Bicubic(4), Metrics([PSNR()]), Protocol(Continuous()), [path])
    first.write(tmp_path)
    second = evaluate(Bicubic(4), Metrics([], [Count()]), Protocol(Continuous()), [path])
    merged = second.merge(read_scores(tmp_path / "frames.parquet"))
    assert merged.frames["psnr"].tolist() == first.frames["psnr"].tolist()
    assert merged.clips["psnr"].tolist() == first.clips["psnr"].tolist()
    assert merged.clips["seen"].tolist() == [5.0, 5.0]


def test_warm_up_longer_than_the_clips_is_error(path):
    with pytest.raises(UserError, match="warm_up=5: use less than the 5 frames"):
        evaluate(Bicubic(4), Metrics([PSNR()]), Protocol(Continuous(), warm_up=5), [path])


class Ramp(Bicubic):
    """With a picture of its step: the column of the target position, one darker window, and the frame's number."""

    over_time = frozenset({"ramp"})

    def __init__(self, scale):
        super().__init__(scale)
        self.requires = frozenset({"color", "jitter"})

    def step_images(self, frame, state):
        return {"ramp": picture_of(frame.jitter), "once": torch.full((1, 3, 48, 64), 0.5)}


def picture_of(jitter):
    picture = torch.linspace(0.4, 1, 64)[None, None, None].expand(1, 1, 48, 64).clone()
    picture[..., 24:32, 40:48] = 0.5 + jitter[0, 0] / 2
    return picture


def test_pictures_over_time_are_of_the_darkest_window_with_a_dot_at_each_sample(path, tmp_path):
    evaluate(Ramp(4), Metrics([PSNR()]), Protocol(Continuous()), [path]).write(tmp_path)
    with Image.open(tmp_path / "steps" / "0_analytic_ramp.png") as picture:
        strip = np.asarray(picture)
    with Image.open(tmp_path / "state" / "0_analytic_once.png") as picture:
        assert (np.asarray(picture) == 128).all()
    assert sorted(p.name for p in (tmp_path / "state").iterdir()) == ["0_analytic_once.png", "0_analytic_ramp.png"]
    assert [p.name for p in (tmp_path / "steps").iterdir()] == ["0_analytic_ramp.png"]
    # All five frames of the clip: windows of 8x8 pixels, 16 times as large, 8 apart.
    assert strip.shape == (128, 5 * 128 + 4 * 8, 3)
    file = DatasetFile(path)
    jitters = torch.from_numpy(file.read("jitter", 0, slice(0, 5)))
    y, x = detailed_corner(torch.from_numpy(file.read("target", 0, slice(4, 5))), 48)
    mean = torch.stack([picture_of(jitter[None])[0, 0] for jitter in jitters]).mean(0)
    corners = [(i, j) for i in range(y, y + 41) for j in range(x, x + 41) if i % 4 == j % 4 == 0]
    top, left = min(corners, key=lambda c: mean[c[0] : c[0] + 8, c[1] : c[1] + 8].mean().item())
    for k, jitter in enumerate(jitters):
        tile = strip[:, k * 136 : k * 136 + 128]
        red = (tile == (214, 39, 40)).all(axis=-1)
        for i in range(2):
            for j in range(2):
                expected = [(4 * (n + 0.5 + float(o)) * 16) for n, o in ((i, jitter[1]), (j, jitter[0]))]
                inside = red[i * 64 : i * 64 + 64, j * 64 : j * 64 + 64].nonzero()
                centre = (np.mean(inside, axis=1) + 0.5) + (i * 64, j * 64)
                np.testing.assert_allclose(centre, expected, atol=1.5)
        grey = picture_of(jitter[None])[0, 0, top : top + 8, left : left + 8].mul(255).round().numpy()
        np.testing.assert_array_equal(tile[0::16, 0::16, 0], grey)
