"""Frames in turn, a state that is full before timing, and times of a fake clock."""

import statistics

import numpy as np
import pytest
import torch
from fake_time import Clock
from hydra.utils import instantiate

from supersampling.deploy.check import buffers
from supersampling.models.count import LONGEST
from supersampling.profiling import stream
from supersampling.profiling.backends import Stream
from supersampling.profiling.stream import SETTLING, Streaming, cache_size, distinct_frames, spread

CPU = torch.device("cpu")


class RecordingStream(Stream):
    """A stream that records its frames.

    Its state has one tensor per frame, at most ``full``; a frame, which is a number, takes that many seconds.
    """

    def __init__(self, full=3, clock=None):
        self.full, self.clock, self.seen = full, clock, []

    def prepare(self, frame):
        return frame

    def step(self, prepared):
        self.seen.append(prepared)
        if self.clock:
            self.clock.work(float(prepared))

    def image(self, result):
        raise AssertionError

    def reset(self):
        raise AssertionError

    def shapes(self):
        return [(1,)] * min(len(self.seen), self.full)


def test_frames_come_in_turn():
    recording = RecordingStream()
    streaming = Streaming(recording, [5, 6, 7], CPU)
    streaming.time(4, 1e9)
    streaming.time(1, 1e9)
    assert recording.seen == [5, 6, 7, 5, 6, 7, 5]  # one frame before each timing


@pytest.mark.parametrize("full", [0, 1, 3, 10])
def test_warm_up_ends_once_the_state_is_full(full):
    recording = RecordingStream(full)
    Streaming(recording, [0], CPU).warm_up()
    # One more frame shows that the state has stopped growing; without a state, two frames are enough.
    assert len(recording.seen) == max(full + 1, 2) + SETTLING


def test_endless_state_is_an_error():
    with pytest.raises(RuntimeError, match="still grows"):
        Streaming(RecordingStream(LONGEST + 1), [0], CPU).warm_up()


def test_times_are_those_of_the_clock():
    clock = Clock()
    streaming = Streaming(RecordingStream(clock=clock), [9, 1, 2, 3, 4], CPU, clock)
    assert streaming.time(6, 1e9) == [1, 2, 3, 4, 9, 1]


@pytest.mark.parametrize(("seconds", "expected"), [(3.5, [1, 2, 3]), (0.1, [1]), (6.0, [1, 2, 3])])
def test_round_ends_after_its_seconds(seconds, expected):
    clock = Clock()
    assert Streaming(RecordingStream(clock=clock), [9, 1, 2, 3, 4], CPU, clock).time(100, seconds) == expected


@pytest.mark.parametrize("count", [2, 5, 8, 101])
def test_quartiles(count):
    values = np.random.default_rng(count).random(count).tolist()
    low, median, high = statistics.quantiles(values, n=4, method="inclusive")
    result = spread(values)
    assert (result.low, result.median, result.high) == pytest.approx((low, median, high))
    assert result.count == count


def test_distinct_frames_are_larger_than_a_cache(composed):
    model = instantiate(composed("model=dlctus").model)
    jitters = torch.rand(3, 2) - 0.5
    frames = distinct_frames(model, 16, 12, jitters, cache=50_000)
    assert sum(v.nbytes for f in frames for v in buffers(f).values()) > 50_000
    assert len({f.color.numpy().tobytes() for f in frames}) == len(frames)
    assert all(torch.equal(f.jitter[0], jitters[t % 3]) for t, f in enumerate(frames))
    # Motion of neighbours differs by a fraction of the range.
    motion = frames[0].motion
    assert motion.abs().max() <= 0.01
    assert motion.diff(dim=-1).abs().max() < 0.02 / 2


def test_number_of_frames_is_bounded(composed):
    model = instantiate(composed("model=dlctus").model)
    assert len(distinct_frames(model, 16, 12, None, 0)) == stream.FEWEST
    assert len(distinct_frames(model, 16, 12, None, 2**40)) == stream.MOST


def test_cache_size(monkeypatch, tmp_path):
    for k, size in enumerate(("32K", "512K", "2M")):
        (tmp_path / f"index{k}").mkdir()
        (tmp_path / f"index{k}" / "size").write_text(f"{size}\n")
    monkeypatch.setattr(stream, "_CACHES", tmp_path)
    assert cache_size() == 2 * 2**20
    monkeypatch.setattr(stream, "_CACHES", tmp_path / "missing")
    assert cache_size() == 32 * 2**20
