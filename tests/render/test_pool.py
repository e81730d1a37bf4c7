"""Several processes render the same files as one, even if killed, and only requested buffers are rendered."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from supersampling.data.dataset_file import DatasetFile
from supersampling.data.spec import CaptureSpec
from supersampling.errors import UserError
from supersampling.render.pool import render_files
from supersampling.render.renderer import Renderer

ROOT = Path(__file__).resolve().parents[2]
USUAL = frozenset({"color", "motion", "jitter", "target"})
SPEC = CaptureSpec(
    scene="foundry",
    split="train",
    clips=4,
    frames=3,
    targets=2,
    frame=(192, 108),
    window=(48, 48),
    scale=4,
    jitter="thesis",
    mip_bias="matched",
    samples=2,
    seed=0,
    candidates=1,
)
COMMAND = f"""
import sys
from pathlib import Path
from supersampling.data.spec import CaptureSpec
from supersampling.render.pool import render_files
if __name__ == "__main__":
    render_files([{SPEC}], Path(sys.argv[1]), {USUAL}, int(sys.argv[2]))
"""


@pytest.fixture(scope="module")
def alone(tmp_path_factory) -> Path:
    return render_files([SPEC], tmp_path_factory.mktemp("alone"), USUAL)[0]


@pytest.fixture
def script(tmp_path) -> Path:
    path = tmp_path / "render_them.py"
    path.write_text(COMMAND)
    return path


def test_two_processes_of_one_command_render_the_same_bytes(alone, tmp_path):
    together = render_files([SPEC], tmp_path, USUAL, workers=2)[0]
    assert together.read_bytes() == alone.read_bytes()
    assert not list(tmp_path.glob("*.clips"))


def test_two_commands_share_the_clips_of_a_file(alone, script, tmp_path):
    folder = tmp_path / "data"
    run = [sys.executable, str(script), str(folder), "1"]
    commands = [subprocess.Popen(run, cwd=ROOT, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    for command in commands:
        assert command.wait(timeout=120) == 0, command.stderr.read() if command.stderr else ""
    assert [p.read_bytes() for p in folder.glob("*.h5")] == [alone.read_bytes()]
    assert not list(folder.glob("*.clips"))


def test_a_killed_command_leaves_its_finished_clips_and_the_file_comes_out_the_same(alone, script, tmp_path):
    folder = tmp_path / "data"
    run = [sys.executable, str(script), str(folder), "2"]
    process = subprocess.Popen(run, cwd=ROOT, stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 90
    while not list(folder.glob("*.clips/*.h5")) and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.01)
    os.kill(process.pid, signal.SIGKILL)  # its rendering processes find out and end
    process.wait()
    finished = {p.name: p.read_bytes() for p in folder.glob("*.clips/*.h5")}
    assert finished or list(folder.glob("*.h5"))
    done = subprocess.run(run, cwd=ROOT, capture_output=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert [p.read_bytes() for p in folder.glob("*.h5")] == [alone.read_bytes()]


def test_error_of_worker_reaches_user_in_one_sentence(tmp_path):
    from dataclasses import replace

    with pytest.raises(UserError, match="Unknown scene atrum"):
        render_files([replace(SPEC, scene="atrum")], tmp_path, USUAL, workers=2)


def test_only_requested_buffers_are_rendered_and_stored(tmp_path, monkeypatch):
    requested: list[frozenset[str]] = []
    low, high = Renderer.low, Renderer.high

    def spy_low(self, shot, scale, jitter, mip_bias, buffers):
        requested.append(buffers)
        return low(self, shot, scale, jitter, mip_bias, buffers)

    def spy_high(self, shot, samples, mip_bias, buffers):
        requested.append(buffers)
        return high(self, shot, samples, mip_bias, buffers)

    monkeypatch.setattr(Renderer, "low", spy_low)
    monkeypatch.setattr(Renderer, "high", spy_high)
    path = render_files([SPEC], tmp_path, frozenset({"color", "target"}))[0]
    assert DatasetFile(path).buffers == {"color", "target"}
    assert set(requested) == {frozenset({"color"}), frozenset({"target"})}
    before = DatasetFile(path)
    first = {name: before.read(name, 0, slice(1, None)) for name in ("color", "target")}
    prints = before.fingerprint(["color", "target"])
    before.close()
    requested.clear()
    path = render_files([SPEC], tmp_path, frozenset({"color", "material", "target"}))[0]
    assert set(requested) == {frozenset({"material"})}  # what is there is not rendered again
    after = DatasetFile(path)
    assert after.buffers == {"color", "material", "target"}
    assert after.fingerprint(["color", "target"]) == prints
    for name, values in first.items():
        np.testing.assert_array_equal(after.read(name, 0, slice(1, None)), values)
