"""Every backend gives what the method itself gives, frame after frame; one that is not there says so."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate

from supersampling.deploy.check import random_frames
from supersampling.models.bicubic import Bicubic
from supersampling.profiling.backends import ChannelsLast, Compile, Eager, Setting
from supersampling.profiling.bound import BoundStream
from supersampling.profiling.graphs import Exported, TensorRT, WithOnnxRuntime, WithOpenVINO
from supersampling.render.jitter import jitter_sequence

CPU = torch.device("cpu")
SIZE = (16, 12)
JITTERS = torch.from_numpy(jitter_sequence("thesis", 4))
SETTING = Setting(*SIZE, "float32", CPU, 1, JITTERS)


class Bound(Exported):
    """What runs on CUDA, on the processor."""

    name, module = "bound", "onnxruntime"

    def refused(self, device, precision):
        return ""

    def open(self, path, setting):
        return BoundStream(path, ["CPUExecutionProvider"], setting)


def images(stream, frames):
    return torch.stack([stream.image(stream.step(stream.prepare(frame))) for frame in frames])


@pytest.fixture(scope="module", params=["dlctus", pytest.param("enss_s", marks=pytest.mark.slow)])
def method(request):
    """A configuration, frames, and the images that the method makes of them when it is called as models are."""
    from hydra import compose, initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra

    GlobalHydra.instance().clear()
    with initialize_config_dir(str(Path(__file__).resolve().parents[2] / "conf"), version_base="1.3"):
        config = compose("benchmark", [f"model={request.param}"]).model

    def make():
        torch.manual_seed(0)
        return instantiate(config)

    model = make().eval()
    frames = list(random_frames(model, SIZE, 6, JITTERS))
    state, expected = None, []
    with torch.no_grad():
        for frame in frames:
            output, state = model(frame, state)
            expected.append(model.present(output, frame))
    return make, frames, torch.stack(expected)


@pytest.mark.parametrize(
    "backend",
    [Eager(), ChannelsLast(), WithOnnxRuntime(), WithOpenVINO(), Bound(), pytest.param(Compile(), marks=pytest.mark.slow)],
    ids=lambda b: b.name,
)  # fmt: skip
def test_it_is_the_method(method, backend):
    make, frames, expected = method
    assert backend.missing(CPU, "float32") == ""
    stream = backend.load(make(), SETTING)
    found = images(stream, frames)
    assert found.shape == expected.shape
    assert (found - expected).abs().max() < 1e-4
    # A state that were not carried would show: the same frames make other images without their past.
    assert (images(backend.load(make(), SETTING), frames[-1:]) - expected[-1:]).abs().max() > 1e-2
    assert stream.shapes()
    stream.reset()
    assert torch.equal(images(stream, frames[:2]), found[:2])


@pytest.mark.parametrize("backend", [Eager(), ChannelsLast()], ids=lambda b: b.name)
def test_half_precision_is_near(method, backend):
    make, frames, expected = method
    found = images(backend.load(make(), replace(SETTING, precision="bfloat16")), frames)
    apart = (found - expected).abs().max()
    assert 1e-5 < apart < 0.03


def test_a_frame_is_laid_out_as_the_backend_reads_it(method):
    make, frames, _ = method
    prepared = ChannelsLast().load(make(), SETTING).prepare(frames[0])
    assert prepared.color.is_contiguous(memory_format=torch.channels_last)
    assert torch.equal(prepared.color, frames[0].color)
    convolutions = [m for m in ChannelsLast().load(make(), SETTING).model.modules() if isinstance(m, torch.nn.Conv2d)]
    assert all(c.weight.is_contiguous(memory_format=torch.channels_last) for c in convolutions)


def test_what_is_compiled_has_no_parts():
    assert Eager().load(Bicubic(2), SETTING).model is not None
    assert Compile().load(Bicubic(2), SETTING).model is None


def test_graphs_are_gone_once_they_are_loaded(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    WithOnnxRuntime().load(Bicubic(2), replace(SETTING, jitters=None))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("backend", "device", "precision", "sentence"),
    [
        (TensorRT(), "cpu", "float32", "TensorRT needs an NVIDIA GPU."),
        (WithOpenVINO(), "cuda", "float32", "OpenVINO does not run on CUDA."),
        (WithOnnxRuntime(), "cpu", "bfloat16", "ONNX Runtime runs a float32 graph in float32"),
        (WithOnnxRuntime(), "cuda", "float32", "has no CUDAExecutionProvider: pip install onnxruntime-gpu."),
        (Eager(), "cpu", "int8", "It does not compute in int8: that needs a quantised graph."),
    ],
)
def test_what_does_not_run_says_why(backend, device, precision, sentence):
    assert sentence in backend.missing(torch.device(device), precision)


def test_what_is_not_installed_says_so(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert WithOpenVINO().missing(CPU, "float32") == "openvino is not installed: pip install openvino."
    assert TensorRT().missing(torch.device("cuda"), "float32").endswith("pip install onnxruntime.")
