"""Files, output and errors of ``export.py``."""

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
    settings = ["scene=atrium", "model=jau", "threads=1", "check=4", f"out={tmp_path}/jau.onnx"]
    return lambda *overrides: entry("export", *settings, *overrides)


def test_method_without_state_is_one_graph_and_runs_on_a_data_set(configure, make_file, tmp_path, capsys):
    data = make_file(tmp_path, "test", frames=3)
    export(configure("data=files", f"data.test=[{data}]", "frames=data"))
    output = capsys.readouterr().out
    assert "onnxruntime: at most" in output
    assert "openvino: at most" in output
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix != ".h5") == ["jau.json", "jau.onnx"]
    description = json.loads((tmp_path / "jau.json").read_text())
    assert description["method"] == "jau"
    assert description["scale"] == 4
    assert description["graphs"] == {"first": "jau.onnx", "next": "jau.onnx"}
    assert description["state"] == []
    assert len(description["jitter"]["sequence"]) == 16
    runners = {"onnxruntime": Runner(tmp_path / "jau.onnx", OnnxRuntime(threads=1))}
    frames = recorded_frames(data, JAU(4).requires, None, 1, 5)
    assert compare(JAU(4), runners, frames)["onnxruntime"].largest < 1e-5


def test_graph_above_the_tolerance_is_not_written(configure, monkeypatch, tmp_path):
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
def test_invalid_settings(override, part, configure):
    with pytest.raises(UserError, match=part):
        export(configure(override))


def test_checkpoint_excludes_run(configure):
    with pytest.raises(UserError, match="exclude each other"):
        export(configure("checkpoint=a.ckpt", "run=b"))
