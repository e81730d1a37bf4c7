"""What ``export.py`` writes, says and refuses."""

import json

import pytest

from supersampling.commands.export import export
from supersampling.deploy.check import Difference, compare, recorded_frames
from supersampling.deploy.runner import Runner
from supersampling.deploy.runtimes import OnnxRuntime
from supersampling.errors import UserError
from supersampling.models.jau import JAU


@pytest.fixture
def configure(entry, tmp_path):
    given = ["scene=atrium", "model=jau", "threads=1", "check=4", f"out={tmp_path}/jau.onnx"]
    return lambda *overrides: entry("export", *given, *overrides)


def test_a_method_without_state_is_one_graph_and_runs_on_a_data_set(configure, make_file, tmp_path, capsys):
    data = make_file(tmp_path, "test", frames=3)
    export(configure("data=files", f"data.test=[{data}]", "frames=data"))
    said = capsys.readouterr().out
    assert "onnxruntime: at most" in said
    assert "openvino: at most" in said
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix != ".h5") == ["jau.json", "jau.onnx"]
    description = json.loads((tmp_path / "jau.json").read_text())
    assert description["method"] == "jau"
    assert description["scale"] == 4
    assert description["graphs"] == {"first": "jau.onnx", "next": "jau.onnx"}
    assert description["state"] == []
    assert len(description["jitter"]["sequence"]) == 16
    runners = {"again": Runner(tmp_path / "jau.onnx", OnnxRuntime(threads=1))}
    frames = recorded_frames(data, JAU(4).requires, None, 1, 5)
    assert compare(JAU(4), runners, frames)["again"].largest < 1e-5


def test_what_is_too_far_off_is_not_written(configure, monkeypatch, tmp_path):
    from supersampling.commands import export as command

    monkeypatch.setattr(command, "compare", lambda *_: {"openvino": Difference(0.25, 3, 0.1)})
    with pytest.raises(UserError, match=r"openvino differs from PyTorch by 0.25 at frame 3"):
        export(configure("size=[8,6]"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("override", "part"),
    [
        ("size=[4]", r"size=\[4\]"),
        ("size=[0,4]", r"size=\[0, 4\]"),
        ("out=model.pt", "model.pt"),
        ("kernels=table", "kernels=table"),
        ("frames=film", "frames=film"),
        ("check=0", "check=0"),
        ("tolerance=2", "tolerance=2"),
        ("model=dlctus", "learned"),
        ("task.jitter=spiral", "spiral"),
        ("checkpoint=none.ckpt", "none.ckpt"),
    ],
)
def test_mistakes(override, part, configure):
    with pytest.raises(UserError, match=part):
        export(configure(override))


def test_checkpoint_and_run_exclude_each_other(configure):
    with pytest.raises(UserError, match="exclude each other"):
        export(configure("checkpoint=a.ckpt", "run=b"))
