"""Images of each backend against the method's, frame by frame; reasons of backends that do not run."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from hydra.utils import instantiate

from supersampling.deploy.check import random_frames
from supersampling.models.bicubic import Bicubic
from supersampling.profiling.backends import ChannelsLast, Compile, Eager, LoadOptions
from supersampling.profiling.bound import BoundStream
from supersampling.profiling.graphs import GraphBackend, OnnxRuntimeBackend, OpenVINOBackend, TensorRTBackend
from supersampling.render.jitter import jitter_sequence

CPU = torch.device("cpu")
SIZE = (16, 12)
JITTERS = torch.from_numpy(jitter_sequence("thesis", 4))
OPTIONS = LoadOptions(width=SIZE[0], height=SIZE[1], precision="float32", device=CPU, threads=1, jitters=JITTERS)


class BoundBackend(GraphBackend):
    """The stream for CUDA, on the processor."""

    name, module = "bound", "onnxruntime"

    def limitation(self, device, precision):
        return ""

    def open(self, path, options):
        return BoundStream(path, ["CPUExecutionProvider"], options)


def images(stream, frames):
    return torch.stack([stream.image(stream.step(stream.prepare(frame))) for frame in frames])


@pytest.fixture(scope="module", params=["dlctus", pytest.param("enss_s", marks=pytest.mark.slow)])
def method(request):
    """Return a function that creates a method, frames, and the method's images of them when it is called directly."""
    from hydra import compose, initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra

    GlobalHydra.instance().clear()
    with initialize_config_dir(str(Path(__file__).resolve().parents[2] / "conf"), version_base="1.3"):
        config = compose("benchmark", [f"model={request.param}"]).model

    def create():
        torch.manual_seed(0)
        return instantiate(config)

    model = create().eval()
    frames = list(random_frames(model, SIZE, 6, JITTERS))
    state, expected = None, []
    with torch.no_grad():
        for frame in frames:
            output, state = model(frame, state)
            expected.append(model.present(output, frame))
    return create, frames, torch.stack(expected)


@pytest.mark.parametrize(
    "backend",
    [
        Eager(),
        ChannelsLast(),
        OnnxRuntimeBackend(),
        OpenVINOBackend(),
        BoundBackend(),
        pytest.param(Compile(), marks=pytest.mark.slow),
    ],
    ids=lambda b: b.name,
)
def test_images_equal_those_of_the_method(method, backend):
    create, frames, expected = method
    assert backend.missing(CPU, "float32") == ""
    stream = backend.load(create(), OPTIONS)
    actual = images(stream, frames)
    assert actual.shape == expected.shape
    assert (actual - expected).abs().max() < 1e-4
    # The state matters: without the frames before it, the last frame gives another image.
    assert (images(backend.load(create(), OPTIONS), frames[-1:]) - expected[-1:]).abs().max() > 1e-2
    assert stream.shapes()
    stream.reset()
    assert torch.equal(images(stream, frames[:2]), actual[:2])


@pytest.mark.parametrize("backend", [Eager(), ChannelsLast()], ids=lambda b: b.name)
def test_half_precision_is_near_float32(method, backend):
    create, frames, expected = method
    actual = images(backend.load(create(), replace(OPTIONS, precision="bfloat16")), frames)
    assert 1e-5 < (actual - expected).abs().max() < 0.03


def test_memory_layout_of_a_frame(method):
    create, frames, _ = method
    prepared = ChannelsLast().load(create(), OPTIONS).prepare(frames[0])
    assert prepared.color.is_contiguous(memory_format=torch.channels_last)
    assert torch.equal(prepared.color, frames[0].color)
    convolutions = [m for m in ChannelsLast().load(create(), OPTIONS).model.modules() if isinstance(m, torch.nn.Conv2d)]
    assert all(c.weight.is_contiguous(memory_format=torch.channels_last) for c in convolutions)


def test_compiled_method_has_no_parts():
    assert Eager().load(Bicubic(2), OPTIONS).model is not None
    assert Compile().load(Bicubic(2), OPTIONS).model is None


def test_graph_files_are_deleted_after_loading(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    OnnxRuntimeBackend().load(Bicubic(2), replace(OPTIONS, jitters=None))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("backend", "device", "precision", "sentence"),
    [
        (TensorRTBackend(), "cpu", "float32", "TensorRT needs an NVIDIA GPU."),
        (OpenVINOBackend(), "cuda", "float32", "OpenVINO does not run on CUDA."),
        (OnnxRuntimeBackend(), "cpu", "bfloat16", "ONNX Runtime runs a float32 graph in float32"),
        (OnnxRuntimeBackend(), "cuda", "float32", "has no CUDAExecutionProvider: pip install onnxruntime-gpu."),
        (Eager(), "cpu", "int8", "needs a quantised graph: use backends=[int8]."),
    ],
)
def test_reasons_of_missing_backends(backend, device, precision, sentence):
    assert sentence in backend.missing(torch.device(device), precision)


def test_reasons_of_programs_that_are_not_installed(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert OpenVINOBackend().missing(CPU, "float32") == "openvino is not installed: pip install openvino."
    assert TensorRTBackend().missing(torch.device("cuda"), "float32").endswith("pip install onnxruntime.")
