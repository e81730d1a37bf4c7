"""Clips join into complete files that hold the written buffers, and buffers can be added later."""

import h5py
import numpy as np
import pytest

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import CaptureSpec
from supersampling.data.writer import ClipWriter, buffers_in, join_clips, quantise
from supersampling.frames import BUFFERS

SPEC = CaptureSpec(
    scene="made",
    split="test",
    clips=2,
    frames=3,
    targets=2,
    frame=(96, 64),
    window=(96, 64),
    scale=2,
    jitter="none",
    mip_bias="matched",
    samples=1,
    seed=0,
    candidates=1,
)
NAMES = ("color", "radiance", "motion", "object_id", "jitter", "target", "high_depth")


def frame(name: str, clip: int, t: int) -> np.ndarray:
    buffer = BUFFERS[name]
    rng = np.random.default_rng((clip, t, len(name)))
    if buffer.resolution == "frame":
        return rng.uniform(-0.5, 0.5, 2).astype(np.float32)
    height, width = (64, 96) if buffer.resolution == "high" else (32, 48)
    values = rng.random((height, width, buffer.channels)).astype(np.float32)
    return np.floor(values * 300) if buffer.dtype == "uint16" else values


def write(path, clip: int, names) -> None:
    lengths = {n: SPEC.targets if BUFFERS[n].resolution == "high" else SPEC.frames for n in names}
    with ClipWriter(path, lengths) as writer:
        for name in names:
            for t in range(lengths[name]):
                writer.add(name, frame(name, clip, t))


def make(folder, *groups) -> DatasetFile:
    """Return a file to which groups of buffers were added one after another."""
    folder.mkdir(exist_ok=True)
    for names in groups:
        parts = [folder / f"{clip}_{len(names)}.clip" for clip in range(SPEC.clips)]
        for clip, part in enumerate(parts):
            write(part, clip, names)
        join_clips(folder / "made.h5", SPEC, parts, frozenset(names), {"renderer": "none"})
    return DatasetFile(folder / "made.h5")


@pytest.mark.parametrize("name", NAMES)
def test_written_buffers_are_read_back(name, tmp_path):
    store = make(tmp_path, NAMES)
    high = BUFFERS[name].resolution == "high"
    read = store.read(name, 1, slice(SPEC.frames - SPEC.targets if high else 0, None))
    written = [frame(name, 1, t) for t in range(SPEC.targets if high else SPEC.frames)]
    expected = np.stack(written)
    if BUFFERS[name].resolution != "frame":
        expected = expected.transpose(0, 3, 1, 2)
    step = {"uint8": 0.5 / 255, "float16": 2.0**-11, "float32": 0.0, "uint16": 0.0}[BUFFERS[name].dtype]
    np.testing.assert_allclose(read, expected, rtol=0, atol=step * 1.001)


def test_buffers_added_later_do_not_change_existing_ones(tmp_path):
    once = make(tmp_path / "once", NAMES)
    twice = make(tmp_path / "twice", NAMES[:3], NAMES[3:])
    assert twice.buffers == frozenset(NAMES)
    for names in (NAMES, NAMES[:3], NAMES[3:], ("color",)):
        assert once.fingerprint(names) == twice.fingerprint(names)
    assert once.fingerprint(["color"]) != once.fingerprint(["color", "motion"])
    with h5py.File(tmp_path / "once" / "made.h5") as a, h5py.File(tmp_path / "twice" / "made.h5") as b:
        for name in NAMES:
            np.testing.assert_array_equal(a[name][()], b[name][()])


def test_one_changed_value_changes_the_fingerprint(tmp_path, monkeypatch):
    before = make(tmp_path / "a", NAMES)
    original = frame
    monkeypatch.setitem(globals(), "frame", lambda name, clip, t: original(name, clip, t) * (0.5 if t == 2 else 1.0))
    after = make(tmp_path / "b", NAMES)
    assert before.fingerprint(["radiance"]) != after.fingerprint(["radiance"])
    assert before.fingerprint(["target"]) == after.fingerprint(["target"])  # has two frames only


def test_error_within_a_clip_leaves_no_file(tmp_path):
    def one_frame_then_stop() -> None:
        with ClipWriter(tmp_path / "0.h5", {"color": 3}) as writer:
            writer.add("color", frame("color", 0, 0))
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        one_frame_then_stop()
    assert list(tmp_path.iterdir()) == []
    assert buffers_in(tmp_path / "0.h5") == frozenset()


def test_half_floats_are_clamped_and_stay_finite():
    values = np.array([0.0, 6e-8, 65504.0, 1e9, -1e9], dtype=np.float32)
    stored = quantise("radiance", values)
    assert stored.dtype == np.float16
    assert np.isfinite(stored).all()
    assert stored[3] == 65504.0
