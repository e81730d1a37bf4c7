"""Broken files in the folder of data sets: set aside and written again; whole ones are never touched."""

import fcntl
import os

import h5py
import pytest
from capture_files import frame

from supersampling.data.clipwise import ClipwiseFile
from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError

NAMES = frozenset({"color", "jitter", "target"})
SPEC = CaptureSpec(
    scene="closed/World",
    split="test",
    clips=2,
    frames=2,
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


@pytest.fixture
def clips():
    """Return the clips that were written, in order."""
    return []


@pytest.fixture
def work(tmp_path, clips):
    """Return a function that writes what is missing and returns the file's path."""

    def call(names=NAMES):
        def write(clip, writer, missing):
            clips.append(clip)
            for t in range(SPEC.frames):
                for name, values in frame(t, clip, SPEC.scale, (0.25, 0.0), 1.0).items():
                    if name in missing:
                        writer.add(name, values)
            writer.note(renderer="closed form")

        file = ClipwiseFile(SPEC, tmp_path, names)
        file.work(write, {"software": "test"})
        return file.path

    return call


@pytest.mark.parametrize("size", [0, 1000, -1])
def test_broken_file_is_set_aside_and_written_again(size, work, clips, capsys):
    path = work()
    content = path.read_bytes()
    os.truncate(path, size % len(content))
    broken = path.read_bytes()
    assert work().read_bytes() == content
    assert clips == [0, 1, 0, 1]
    assert path.with_name(f"{path.name}.broken").read_bytes() == broken
    assert f"it is now {path.name}.broken, and its clips are made again." in capsys.readouterr().err


def test_broken_clip_is_written_again(work, clips, tmp_path):
    path = work()
    content = path.read_bytes()
    path.unlink()
    parts = tmp_path / f"{path.name}.clips"
    parts.mkdir()
    (parts / "0000.h5").write_bytes(b"\x89HDF")
    assert work().read_bytes() == content
    assert clips == [0, 1, 0, 1]


def test_locked_file_is_not_touched(work, clips):
    path = work()
    with path.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(UserError, match="is open for writing in another process"):
            work()
    assert clips == [0, 1]
    assert [p.name for p in path.parent.glob("*.broken")] == []


def test_foreign_content_is_not_touched(work, clips, tmp_path):
    path = work()
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = [1.0]
    (tmp_path / "other.h5").replace(path)
    with pytest.raises(UserError, match="an HDF5 file but not a data set"):
        work()
    assert path.exists()


def test_buffers_are_added_to_a_whole_file(work, clips):
    path = work()
    before = DatasetFile(path).fingerprint(NAMES)
    work(NAMES | {"depth"})
    assert clips == [0, 1, 0, 1]
    file = DatasetFile(path)
    assert file.buffers == NAMES | {"depth"}
    assert file.fingerprint(NAMES) == before
    assert file.attributes["renderer"] == "closed form"
