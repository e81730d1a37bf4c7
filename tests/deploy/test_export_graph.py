"""Exported graphs against PyTorch in two other runtimes, over rollouts that carry their own state."""

import json
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate
from small_methods import Aliasing, Even, Growing

from supersampling.deploy.check import arrays, at_other_sizes, compare, random_frames
from supersampling.deploy.describe import describe
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO
from supersampling.errors import UserError
from supersampling.render.jitter import jitter_sequence

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 1.0 / 510.0  # half a step of 8 bits
RUNTIMES = (OnnxRuntime(threads=1), OpenVINO(threads=1))


def written(model, folder, size=None):
    """The file of an export of ``model``, as the command lays it out."""
    graphs = export(model, size)
    path = folder / "method.onnx"
    first = folder / "method.first.onnx"
    graphs.other.save(str(path))
    graphs.first.save(str(first))
    description = describe(model, graphs, (first.name, path.name), {}, {})
    sidecar(path).write_text(json.dumps(description))
    return path, graphs


def runners(path):
    return {runtime.name: Runner(path, runtime) for runtime in RUNTIMES}


def built(name, *overrides):
    """A configured model whose weights are random and large enough that its outputs hang on all of them."""
    GlobalHydra.instance().clear()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        cfg = compose("train", ["scene=atrium", f"model={name}", *overrides])
    torch.manual_seed(0)
    model = instantiate(cfg.model).eval()
    with torch.no_grad():
        for weight in model.parameters():
            fan_in = weight[0].numel() if weight.ndim > 1 else 100
            weight.copy_(torch.randn_like(weight) * (1.5 / fan_in) ** 0.5)
    return model


def assert_same(model, path, size, frames, jitters=None):
    """Both runtimes give PyTorch's images, and would not without their state."""
    found = compare(model, runners(path), random_frames(model, size, frames, jitters))
    assert {name: d.largest < TOLERANCE for name, d in found.items()} == dict.fromkeys(found, True), found
    runner = Runner(path, RUNTIMES[0])
    if not runner.description["state"]:
        return
    carried, forgetful = [], []
    for frame in random_frames(model, size, 4, jitters):
        carried.append(runner(arrays(frame)))
    for frame in random_frames(model, size, 4, jitters):
        runner.reset()
        forgetful.append(runner(arrays(frame)))
    assert np.array_equal(carried[0], forgetful[0])
    assert np.abs(carried[3] - forgetful[3]).max() > 10 * TOLERANCE


@pytest.fixture(scope="module")
def aliasing(tmp_path_factory):
    torch.manual_seed(0)
    model = Aliasing().eval()
    path, graphs = written(model, tmp_path_factory.mktemp("aliasing"))
    return model, path, graphs


@pytest.mark.parametrize("size", [(24, 16), (13, 7), (5, 31)])
def test_a_state_of_copies_and_inputs_survives_sixty_frames_at_any_size(aliasing, size):
    model, path, graphs = aliasing
    assert graphs.multiple == 1
    assert_same(model, path, size, 60)


def test_state_names_and_shapes_are_those_of_the_files(aliasing):
    _, path, _ = aliasing
    said = json.loads(sidecar(path).read_text())
    assert [s["input"] for s in said["state"]] == [
        "state_window_0", "state_window_1", "state_jitter", "state_mean",
    ]  # fmt: skip
    assert [s["shape"] for s in said["state"]] == [[1, 3, "h", "w"], [1, 3, "h", "w"], [1, 2], [1, 3]]
    assert [i["name"] for i in said["inputs"]] == ["color", "high_albedo", "jitter", "motion"]
    assert said["inputs"][1]["shape"] == [1, 3, "2*h", "2*w"]
    buffers, state = [i["name"] for i in said["inputs"]], said["state"]
    for role, held in (("first", []), ("next", [s["input"] for s in state])):
        graph = onnx.load(path.parent / said["graphs"][role]).graph
        assert [i.name for i in graph.input] == [*buffers, *held]
        assert [o.name for o in graph.output] == ["image", *(s["output"] for s in state)]
    runner = Runner(path, RUNTIMES[0])
    assert runner.state == {}
    runner(arrays(next(random_frames(Aliasing(), (6, 5), 1, None))))
    assert [list(t.shape) for t in runner.state.values()] == [[1, 3, 5, 6], [1, 3, 5, 6], [1, 2], [1, 3]]


def test_files_name_no_place_of_the_machine_that_wrote_them(aliasing):
    _, path, _ = aliasing
    for file in path.parent.iterdir():
        assert str(ROOT).encode() not in file.read_bytes(), file.name


def test_the_runner_says_what_is_wrong_with_its_inputs(aliasing):
    model, path, _ = aliasing
    runner = Runner(path, RUNTIMES[0])
    good = arrays(next(random_frames(model, (8, 6), 1, None)))
    with pytest.raises(UserError, match="motion is missing"):
        runner({k: v for k, v in good.items() if k != "motion"})
    with pytest.raises(UserError, match=r"high_albedo has the shape \[1, 3, 6, 8\].*h = 6, w = 8"):
        runner({**good, "high_albedo": good["high_albedo"][..., :6, :8]})
    runner(good)
    with pytest.raises(UserError, match=r"state_window_0 has the shape"):
        runner(arrays(next(random_frames(model, (6, 8), 1, None))))
    with pytest.raises(UserError, match="export.py writes both"):
        Runner(path.parent / "other.onnx", RUNTIMES[0])


def test_a_branch_on_the_size_becomes_a_multiple_that_is_held_to(tmp_path):
    model = Even(4)
    path, graphs = written(model, tmp_path)
    assert graphs.multiple == 4
    assert_same(model, path, (20, 12), 2)
    with pytest.raises(UserError, match="multiples of 4 from 8 up"):
        runners(path)["onnxruntime"](arrays(next(random_frames(model, (13, 7), 1, None))))


def test_a_branch_that_no_multiple_takes_is_found_out_and_goes_with_a_size(tmp_path):
    model = Even(5)
    path, graphs = written(model, tmp_path)
    assert graphs.multiple == 4  # torch.export sees no branch there
    found = at_other_sizes(model, runners(path), graphs.multiple, None)
    assert {size: d.largest > 0.1 for size, d in found.items()} == {
        (8, 12): False,
        (20, 28): False,
        (60, 60): True,
    }
    path, graphs = written(model, tmp_path, (15, 10))
    assert graphs.size == (15, 10)
    assert_same(model, path, (15, 10), 2)
    with pytest.raises(UserError, match=r"takes \[1, 3, 10, 15\]"):
        runners(path)["openvino"](arrays(next(random_frames(model, (20, 10), 1, None))))


def test_a_growing_state_is_refused():
    with pytest.raises(UserError, match="grows"):
        export(Growing(), None)


def test_a_flow_that_leaves_pytorch_is_refused():
    model = built("enss_s", "model/flow=tvl1", "model/kernel_prediction=none")
    with pytest.raises(UserError, match="model/flow=motion_vectors"):
        export(model, (24, 16))


def test_dlctus(tmp_path):
    model = built("dlctus", "task.scale=2")
    path, graphs = written(model, tmp_path)
    assert graphs.multiple in (1, 4)
    assert_same(model, path, (20, 12), 60, torch.from_numpy(jitter_sequence("thesis", 2)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("dlctus", ["task.scale=3", "model/dilate=closest"]),
        ("nsrr", ["model.previous=2"]),
        ("nsrr", ["model.previous=2", "model/warp_at=low", "task.scale=3"]),
        ("nsrd", []),
        ("nsrd", ["model/locate=jitter", "model/base=jitter_aligned", "model/demodulate=log_lighting"]),
        ("enss_s", ["model.kernel_prediction.width=64"]),
        ("tus", []),
    ],
)
def test_every_learned_method(name, overrides, tmp_path):
    model = built(name, *overrides)
    path, graphs = written(model, tmp_path)
    step = graphs.multiple
    size = (20, 12) if step > 1 else (21, 13)
    assert_same(model, path, size, 60, torch.from_numpy(jitter_sequence("thesis", model.scale)))


@pytest.mark.slow
def test_kernels_made_beforehand_are_those_of_the_mlp(tmp_path):
    model = built("enss_s", "model.kernel_prediction.width=64")
    jitters = torch.from_numpy(jitter_sequence("thesis", 4))
    path, graphs = written(model.with_precomputed_kernels(jitters), tmp_path)
    assert_same(model, path, (20, 12) if graphs.multiple > 1 else (21, 13), 60, jitters)
