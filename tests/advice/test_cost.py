"""What compositions cost: times that noise cannot order, bytes by hand, and what is remembered."""

from pathlib import Path

import numpy as np
import pytest

from supersampling.advice import cost
from supersampling.advice.cost import Cost, Remembered, Size, buffer_rows, bytes_of, frame_times, in_turns
from supersampling.models.bicubic import Bicubic
from supersampling.models.nearest import Nearest


def test_a_turn_that_was_slow_for_all_changes_nothing() -> None:
    own = np.array([1.0, 2.0, 3.0])
    load = np.array([1.0, 1.0, 7.0, 1.0, 30.0])
    found = in_turns((own[:, None] * load).tolist())
    assert [c.ms for c in found] == pytest.approx([1.0, 2.0, 3.0])
    assert [c.high - c.low for c in found] == pytest.approx([0, 0, 0], abs=1e-9)


def test_every_model_is_timed() -> None:
    found = frame_times([Nearest(2), Bicubic(2)], Size(8, 6), 3)
    assert all(0 < c.low <= c.ms <= c.high for c in found)


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
    assert bytes_of(name, Size(480, 270), 4) == expected


def test_what_may_be_left_out() -> None:
    rows = buffer_rows({"color", "depth"}, {"color"}, Size(2, 2), 4, {"depth": 0.004})
    assert rows == [
        {"buffer": "color", "needed": True, "bytes": 12, "render_ms": None},
        {"buffer": "depth", "needed": False, "bytes": 16, "render_ms": 4.0},
    ]


def test_times_are_measured_once_and_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def fake(models, size, frames):
        asked.append(len(models))
        return [Cost(len(asked) + k, 0.0, 9.0) for k in range(len(models))]

    monkeypatch.setattr(cost, "frame_times", fake)
    path = tmp_path / "out" / "times.json"
    first = Remembered(path).times(["a", "b"], [Nearest(2), Bicubic(2)], Size(4, 4), 1)
    assert Remembered(path).times(["b", "a"], [Bicubic(2), Nearest(2)], Size(4, 4), 1) == first[::-1]
    assert asked == [2]
    Remembered(path).times(["a", "c"], [Nearest(2), Bicubic(2)], Size(4, 4), 1)  # one is new: all again
    assert asked == [2, 2]
