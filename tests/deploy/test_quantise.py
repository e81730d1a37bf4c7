"""Quantisation to int8 after training: operations, accuracy and errors."""

from itertools import pairwise

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from signal_stack import signal_stack_is_there
from torch import nn

from supersampling.deploy import quantise
from supersampling.deploy.check import arrays, random_frames
from supersampling.deploy.describe import write
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner
from supersampling.deploy.runtimes import OpenVINO, openvino_core
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.jau import JAU
from supersampling.ops.warp import warp

SIZE = 24, 16


class Convolutions(Upsampler):
    """Three convolutions with random weights over a frame and the warped state; one with a kernel from the jitter."""

    scale = 2
    requires = frozenset({"color", "motion", "jitter"})

    def __init__(self):
        super().__init__()
        torch.manual_seed(0)
        widths = (11, 16, 16, 12)
        self.body = nn.ModuleList(nn.Conv2d(a, b, 3, padding=1) for a, b in pairwise(widths))

    def forward(self, frame, state):
        before = torch.zeros_like(frame.color).repeat(1, 2, 1, 1) if state is None else state[0]
        kernel = (frame.jitter.mean() + 1.0) / 9.0 * torch.ones(2, 1, 3, 3)
        x = torch.cat((frame.color, warp(before, frame.motion), F.conv2d(frame.motion, kernel, padding=1, groups=2)), 1)
        for k, layer in enumerate(self.body):
            x = layer(x) if k == len(self.body) - 1 else layer(x).relu()
        return F.pixel_shuffle(x, 2).sigmoid(), (x[:, :6].tanh(),)


def export_file(model, folder, size=None):
    path = folder / "method.onnx"
    write(path, model, export(model, size))
    return path


@pytest.fixture(scope="module")
def model():
    return Convolutions().eval()


@pytest.fixture(scope="module")
def path(model, tmp_path_factory):
    return export_file(model, tmp_path_factory.mktemp("float"))


@pytest.fixture(scope="module")
def quantised(model, path):
    pytest.importorskip("nncf")
    return quantise.quantise(path, [random_frames(model, SIZE, 8, None), random_frames(model, (16, 16), 4, None)])


def test_samples_come_from_a_rollout(model, path):
    """The state equals PyTorch's, is reset for each clip, and a clip's first frame gives no sample."""
    clips = [list(random_frames(model, SIZE, 3, None)), list(random_frames(model, SIZE, 2, None))]
    samples = quantise.samples(path, clips)
    assert len(samples) == 2 + 1
    with torch.no_grad():
        state = None
        for frame, sample in zip(clips[0], [None, *samples[:2]]):
            if sample is not None:
                assert np.array_equal(sample["color"], frame.color.numpy())
                (carried,) = [v for k, v in sample.items() if k.startswith("state")]
                np.testing.assert_allclose(carried, state[0].numpy(), atol=1e-5)
            _, state = model(frame, state)


def test_only_convolutions_with_fixed_weights_are_quantised(quantised):
    ops = openvino_core().read_model(quantised).get_ops()
    sources = [
        (op.get_type_name(), op.input_value(0).get_node().get_type_name())
        for op in ops
        if op.get_type_name() in quantise.CONVOLUTIONS
    ]
    assert sorted(sources)[:3] == [("Convolution", "FakeQuantize")] * 3
    assert len(sources) == 4
    assert sorted(sources)[3][0] == "GroupConvolution"
    assert sorted(sources)[3][1] != "FakeQuantize"


def test_signal_stack_is_there_after_quantisation(quantised):
    assert signal_stack_is_there()


def test_quantised_method_is_near_pytorch_with_its_own_state(model, quantised):
    runner = Runner(quantised, OpenVINO(threads=1))
    state, differences = None, []
    with torch.no_grad():
        for frame in random_frames(model, SIZE, 12, None):
            image, state = model(frame, state)
            differences.append(np.abs(runner(arrays(frame)) - image.numpy()))
    assert differences[0].max() < 1e-5  # the first frame is float32
    assert 1e-5 < differences[-1].max() < 0.03  # the images' spread is 0.4


def test_graph_of_a_fixed_size_is_calibrated_with_tiled_frames(model, tmp_path):
    pytest.importorskip("nncf")
    clip = [quantise.tiled(frame, (20, 12), 2) for frame in random_frames(model, (8, 8), 4, None)]
    runner = Runner(quantise.quantise(export_file(model, tmp_path, (20, 12)), [clip]), OpenVINO(threads=1))
    for frame in random_frames(model, (20, 12), 2, None):
        assert runner(arrays(frame)).shape == (1, 3, 24, 40)


def test_tiles_keep_motion_in_pixels():
    color = torch.arange(12.0).reshape(1, 1, 3, 4)
    motion = torch.full((1, 2, 3, 4), 0.5)
    albedo = torch.rand(1, 3, 6, 8)
    jitter = torch.rand(1, 2)
    large = quantise.tiled(Frame(color=color, motion=motion, high_albedo=albedo, jitter=jitter), (10, 5), 2)
    assert torch.equal(large.color[0, 0, 4], torch.tensor([4.0, 5, 6, 7, 4, 5, 6, 7, 4, 5]))
    assert torch.equal(large.high_albedo[..., 6:, 16:], albedo[..., :4, :4])
    assert torch.equal(large.jitter, jitter)
    assert large.depth is None
    np.testing.assert_allclose(large.motion[0, :, 2, 7], [0.5 * 4 / 10, 0.5 * 3 / 5])


def test_errors(model, path, tmp_path, monkeypatch):
    pytest.importorskip("nncf")
    with pytest.raises(UserError, match="frames to calibrate on"):
        quantise.quantise(path, [random_frames(model, SIZE, 1, None)])
    plain = export_file(JAU(4), tmp_path)
    with pytest.raises(UserError, match="no convolution with fixed weights"):
        quantise.quantise(plain, [random_frames(JAU(4), SIZE, 2, None)])
    monkeypatch.setattr(quantise.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"supersampling\[int8\]"):
        quantise.quantise(path, [])
