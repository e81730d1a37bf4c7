"""An import that is killed loses only the clip in progress."""

import multiprocessing
import os
import random
import signal
import time

import pytest
from capture_files import make_source

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.exporters.exporting import export
from supersampling.data.readers.importing import import_capture

CLIPS = 6


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("resume")
    return export("qrisp", make_source(folder / "source", clips=CLIPS, frames=6), folder / "capture")


def start(capture, out):
    """Import in a separate process, which a server forks: torch's threads in this one do not survive a fork."""
    process = multiprocessing.get_context("forkserver").Process(
        target=import_capture, args=("qrisp", capture, out), kwargs={"scale": 2}
    )
    process.start()
    return process


def finished(out):
    return {p.name: p.read_bytes() for p in out.glob("*.clips/*.h5")}


def test_import_killed_three_times_equals_undisturbed_import(capture, tmp_path):
    (whole,) = import_capture("qrisp", capture, tmp_path / "whole", scale=2)
    out, rng = tmp_path / "killed", random.Random(7)
    previous: dict[str, bytes] = {}
    for clips in (1, 3, 4):
        process = start(capture, out)
        while len(finished(out)) < clips and process.is_alive():
            time.sleep(0.001)
        time.sleep(rng.uniform(0.0, 0.03))
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        assert not list(out.glob("*.h5")), "killed too late to prove anything"
        now = finished(out)
        assert now.items() >= previous.items()
        previous = now
    assert len(previous) >= 4
    (resumed,) = import_capture("qrisp", capture, out, scale=2)
    assert resumed.name == whole.name
    assert resumed.read_bytes() == whole.read_bytes()
    assert [p.name for p in out.iterdir() if not p.name.startswith(".")] == [whole.name]


def test_three_processes_share_import(capture, tmp_path):
    (whole,) = import_capture("qrisp", capture, tmp_path / "whole", scale=2)
    out = tmp_path / "shared"
    processes = [start(capture, out) for _ in range(3)]
    for process in processes:
        process.join(60)
        assert process.exitcode == 0
    assert (out / whole.name).read_bytes() == whole.read_bytes()
    assert not list(out.glob("*.clips"))


def test_finished_import_is_not_repeated(capture, tmp_path):
    (first,) = import_capture("qrisp", capture, tmp_path, scale=2)
    modified = first.stat().st_mtime_ns
    assert import_capture("qrisp", capture, tmp_path, scale=2) == [first]
    assert first.stat().st_mtime_ns == modified
    assert DatasetFile(first).spec.clips == CLIPS
