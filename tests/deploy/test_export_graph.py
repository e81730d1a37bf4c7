"""Exported graphs against PyTorch in two other runtimes, over rollouts that carry their own state."""

import json
import shutil
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.utils import instantiate
from small_methods import Aliasing, Even, Growing

from supersampling.deploy.check import arrays, compare, compare_other_sizes, random_frames
from supersampling.deploy.describe import write
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO
from supersampling.errors import UserError
from supersampling.render.jitter import jitter_sequence

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 1.0 / 510.0  # half a step of 8 bits
RUNTIMES = (OnnxRuntime(threads=1), OpenVINO(threads=1))


def export_files(model, folder, size=None):
    """Export ``model`` as the command does; return the graph's file and the graphs."""
    graphs = export(model, size)
    path = folder / "method.onnx"
    write(path, model, graphs)
    return path, graphs


def runners(path):
    return {runtime.name: Runner(path, runtime) for runtime in RUNTIMES}


def build(name, *overrides):
    """Return a configured model with random weights, large enough to let its outputs depend on all of them."""
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
    """Assert that both runtimes return PyTorch's images, and that they would not without their state."""
    differences = compare(model, runners(path), random_frames(model, size, frames, jitters))
    assert all(difference.largest < TOLERANCE for difference in differences.values()), differences
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
    path, graphs = export_files(model, tmp_path_factory.mktemp("aliasing"))
    return model, path, graphs


@pytest.mark.parametrize("size", [(24, 16), (13, 7), (5, 31)])
def test_state_of_copies_and_inputs_is_right_for_sixty_frames_at_all_sizes(aliasing, size):
    model, path, graphs = aliasing
    assert graphs.multiple == 1
    assert_same(model, path, size, 60)


def test_state_names_and_shapes_are_those_of_the_files(aliasing):
    _, path, _ = aliasing
    description = json.loads(sidecar(path).read_text())
    names = ["state_window_0", "state_window_1", "state_jitter", "state_mean"]
    assert [s["input"] for s in description["state"]] == names
    assert [s["shape"] for s in description["state"]] == [[1, 3, "h", "w"], [1, 3, "h", "w"], [1, 2], [1, 3]]
    assert [i["name"] for i in description["inputs"]] == ["color", "high_albedo", "jitter", "motion"]
    assert description["inputs"][1]["shape"] == [1, 3, "2*h", "2*w"]
    buffers, state = [i["name"] for i in description["inputs"]], description["state"]
    for role, state_names in (("first", []), ("next", [s["input"] for s in state])):
        graph = onnx.load(path.parent / description["graphs"][role]).graph
        assert [i.name for i in graph.input] == [*buffers, *state_names]
        assert [o.name for o in graph.output] == ["image", *(s["output"] for s in state)]
    runner = Runner(path, RUNTIMES[0])
    assert runner.state == {}
    runner(arrays(next(random_frames(Aliasing(), (6, 5), 1, None))))
    assert [list(t.shape) for t in runner.state.values()] == [[1, 3, 5, 6], [1, 3, 5, 6], [1, 2], [1, 3]]


def test_files_contain_no_path_of_the_machine_that_wrote_them(aliasing):
    _, path, _ = aliasing
    for file in path.parent.iterdir():
        assert str(ROOT).encode() not in file.read_bytes(), file.name


def test_messages_for_invalid_inputs_of_the_runner(aliasing):
    model, path, _ = aliasing
    runner = Runner(path, RUNTIMES[0])
    good = arrays(next(random_frames(model, (8, 6), 1, None)))
    with pytest.raises(UserError, match="motion is missing"):
        runner({k: v for k, v in good.items() if k != "motion"})
    with pytest.raises(UserError, match=r"\[1, 3, 6, 8\] of high_albedo.*h = 6, w = 8"):
        runner({**good, "high_albedo": good["high_albedo"][..., :6, :8]})
    runner(good)
    with pytest.raises(UserError, match="of state_window_0, this graph takes"):
        runner(arrays(next(random_frames(model, (6, 8), 1, None))))
    with pytest.raises(UserError, match="write both again with export.py"):
        Runner(path.parent / "other.onnx", RUNTIMES[0])


def test_changed_graph_is_not_run(aliasing, tmp_path):
    _, path, _ = aliasing
    folder = Path(shutil.copytree(path.parent, tmp_path / "copy"))
    data = bytearray((folder / path.name).read_bytes())
    data[len(data) // 2] ^= 1
    (folder / path.name).write_bytes(data)
    with pytest.raises(UserError, match=r"\.onnx is not as export\.py wrote it: write it again"):
        Runner(folder / path.name, RUNTIMES[0])


def test_branch_on_the_size_becomes_a_multiple_that_the_runner_enforces(tmp_path):
    model = Even(4)
    path, graphs = export_files(model, tmp_path)
    assert graphs.multiple == 4
    assert_same(model, path, (20, 12), 2)
    with pytest.raises(UserError, match="multiples of 4, at least 8"):
        runners(path)["onnxruntime"](arrays(next(random_frames(model, (13, 7), 1, None))))


def test_branch_that_no_multiple_satisfies_is_detected_and_needs_a_size(tmp_path):
    model = Even(5)
    path, graphs = export_files(model, tmp_path)
    assert graphs.multiple == 4  # torch.export sees no branch there
    differences = compare_other_sizes(model, runners(path), graphs.multiple, None)
    wrong = {size: difference.largest > 0.1 for size, difference in differences.items()}
    assert wrong == {(8, 12): False, (20, 28): False, (60, 60): True}
    path, graphs = export_files(model, tmp_path, (15, 10))
    assert graphs.size == (15, 10)
    assert_same(model, path, (15, 10), 2)
    with pytest.raises(UserError, match=r"takes \[1, 3, 10, 15\]"):
        runners(path)["openvino"](arrays(next(random_frames(model, (20, 10), 1, None))))


def test_growing_state_is_an_error():
    with pytest.raises(UserError, match="grows"):
        export(Growing(), None)


def test_flow_outside_of_pytorch_is_an_error():
    model = build("enss_s", "model/flow=tvl1", "model/kernel_prediction=none")
    with pytest.raises(UserError, match="model/flow=motion_vectors"):
        export(model, (24, 16))


def test_dlctus(tmp_path):
    model = build("dlctus", "task.scale=2")
    path, graphs = export_files(model, tmp_path)
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
def test_learned_methods(name, overrides, tmp_path):
    model = build(name, *overrides)
    path, graphs = export_files(model, tmp_path)
    step = graphs.multiple
    size = (20, 12) if step > 1 else (21, 13)
    assert_same(model, path, size, 60, torch.from_numpy(jitter_sequence("thesis", model.scale)))


@pytest.mark.slow
def test_precomputed_kernels_equal_those_of_the_mlp(tmp_path):
    model = build("enss_s", "model.kernel_prediction.width=64")
    jitters = torch.from_numpy(jitter_sequence("thesis", 4))
    path, graphs = export_files(model.with_precomputed_kernels(jitters), tmp_path)
    assert_same(model, path, (20, 12) if graphs.multiple > 1 else (21, 13), 60, jitters)
