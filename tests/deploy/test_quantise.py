"""int8 by quantisation after training: what is quantised, what it costs, and what is refused."""

import json
from itertools import pairwise

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from signal_stack import signal_stack_is_there
from torch import nn

from supersampling.deploy import quantise
from supersampling.deploy.check import arrays, random_frames
from supersampling.deploy.describe import describe
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OpenVINO, openvino_core
from supersampling.errors import UserError
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.jau import JAU
from supersampling.ops.warp import warp

SIZE = 24, 16


class Convolutions(Upsampler):
    """Three convolutions of random weights over a frame and the warped state, and one whose kernel is made from the jitter."""

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


def exported(model, folder, size=None):
    graphs = export(model, size)
    path, first = folder / "method.onnx", folder / "method.first.onnx"
    graphs.other.save(str(path))
    graphs.first.save(str(first))
    sidecar(path).write_text(json.dumps(describe(model, graphs, (first.name, path.name), {}, {})))
    return path


@pytest.fixture(scope="module")
def model():
    return Convolutions().eval()


@pytest.fixture(scope="module")
def path(model, tmp_path_factory):
    return exported(model, tmp_path_factory.mktemp("float"))


@pytest.fixture(scope="module")
def quantised(model, path):
    pytest.importorskip("nncf")
    return quantise.quantise(path, [random_frames(model, SIZE, 8, None), random_frames(model, (16, 16), 4, None)])


def test_frames_are_what_a_rollout_gives(model, path):
    """The state is PyTorch's, a clip begins anew, and its first frame has none."""
    clips = [list(random_frames(model, SIZE, 3, None)), list(random_frames(model, SIZE, 2, None))]
    given = quantise.samples(path, clips)
    assert len(given) == 2 + 1
    with torch.no_grad():
        state = None
        for frame, held in zip(clips[0], [None, *given[:2]]):
            if held is not None:
                assert np.array_equal(held["color"], frame.color.numpy())
                (carried,) = [v for k, v in held.items() if k.startswith("state")]
                np.testing.assert_allclose(carried, state[0].numpy(), atol=1e-5)
            _, state = model(frame, state)


def test_convolutions_of_fixed_weights_alone_are_quantised(quantised):
    ops = openvino_core().read_model(quantised).get_ops()
    fed = [
        (op.get_type_name(), op.input_value(0).get_node().get_type_name())
        for op in ops
        if op.get_type_name() in quantise.CONVOLUTIONS
    ]
    assert sorted(fed)[:3] == [("Convolution", "FakeQuantize")] * 3
    assert len(fed) == 4
    assert sorted(fed)[3][0] == "GroupConvolution"
    assert sorted(fed)[3][1] != "FakeQuantize"


def test_signals_still_have_a_stack(quantised):
    assert signal_stack_is_there()


def test_it_runs_near_pytorch_with_its_own_state(model, quantised):
    runner = Runner(quantised, OpenVINO(threads=1))
    state, apart = None, []
    with torch.no_grad():
        for frame in random_frames(model, SIZE, 12, None):
            image, state = model(frame, state)
            apart.append(np.abs(runner(arrays(frame)) - image.numpy()))
    assert apart[0].max() < 1e-5  # the first frame is float32
    assert 1e-5 < apart[-1].max() < 0.03  # the images' spread is 0.4


def test_a_graph_of_one_size_is_calibrated_with_tiled_frames(model, tmp_path):
    pytest.importorskip("nncf")
    clip = [quantise.tiled(frame, (20, 12), 2) for frame in random_frames(model, (8, 8), 4, None)]
    runner = Runner(quantise.quantise(exported(model, tmp_path, (20, 12)), [clip]), OpenVINO(threads=1))
    for frame in random_frames(model, (20, 12), 2, None):
        assert runner(arrays(frame)).shape == (1, 3, 24, 40)


def test_tiles_move_by_the_same_pixels():
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


def test_what_is_refused(model, path, tmp_path, monkeypatch):
    pytest.importorskip("nncf")
    with pytest.raises(UserError, match="frames to calibrate on"):
        quantise.quantise(path, [random_frames(model, SIZE, 1, None)])
    plain = exported(JAU(4), tmp_path)
    with pytest.raises(UserError, match="no convolution of fixed weights"):
        quantise.quantise(plain, [random_frames(JAU(4), SIZE, 2, None)])
    monkeypatch.setattr(quantise.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"supersampling\[int8\]"):
        quantise.quantise(path, [])
