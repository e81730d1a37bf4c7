"""The cost of compositions: times under noise, bytes computed by hand, and the cache."""

from pathlib import Path

import numpy as np
import pytest

from supersampling.advice import cost
from supersampling.advice.cost import (
    FrameTime,
    Size,
    TimeCache,
    buffer_rows,
    count_bytes,
    measure_frame_times,
    normalise_turns,
)
from supersampling.models.bicubic import Bicubic
from supersampling.models.nearest import Nearest


def test_turn_that_is_slow_for_all_models_changes_nothing() -> None:
    expected = np.array([1.0, 2.0, 3.0])
    load = np.array([1.0, 1.0, 7.0, 1.0, 30.0])
    times = normalise_turns((expected[:, None] * load).tolist())
    assert [c.ms for c in times] == pytest.approx([1.0, 2.0, 3.0])
    assert [c.high - c.low for c in times] == pytest.approx([0, 0, 0], abs=1e-9)


def test_all_models_are_timed() -> None:
    times = measure_frame_times([Nearest(2), Bicubic(2)], Size(8, 6), 3)
    assert all(0 < c.low <= c.ms <= c.high for c in times)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("color", 480 * 270 * 3),
        ("motion", 480 * 270 * 2 * 4),
        ("high_material", 1920 * 1080 * 3 * 2),
        ("jitter", 2 * 4),
        ("object_id", 480 * 270 * 2),
    ],
)
def test_bytes_of_a_frame(name: str, expected: int) -> None:
    assert count_bytes(name, Size(480, 270), 4) == expected


def test_buffer_rows() -> None:
    rows = buffer_rows({"color", "depth"}, {"color"}, Size(2, 2), 4, {"depth": 0.004})
    assert rows == [
        {"buffer": "color", "needed": True, "bytes": 12, "render_ms": None},
        {"buffer": "depth", "needed": False, "bytes": 16, "render_ms": 4.0},
    ]


def test_times_are_measured_once_and_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = []

    def fake(models, size, frames):
        measured.append(len(models))
        return [FrameTime(len(measured) + k, 0.0, 9.0) for k in range(len(models))]

    monkeypatch.setattr(cost, "measure_frame_times", fake)
    path = tmp_path / "out" / "times.json"
    first = TimeCache(path).times(["a", "b"], [Nearest(2), Bicubic(2)], Size(4, 4), 1)
    assert TimeCache(path).times(["b", "a"], [Bicubic(2), Nearest(2)], Size(4, 4), 1) == first[::-1]
    assert measured == [2]
    TimeCache(path).times(["a", "c"], [Nearest(2), Bicubic(2)], Size(4, 4), 1)  # One is new: all are measured again.
    assert measured == [2, 2]
