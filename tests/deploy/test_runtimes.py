"""State of the process after graphs are loaded and deleted."""

import gc

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper
from signal_stack import signal_stack_is_there

from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO


@pytest.fixture
def graph(tmp_path):
    """The file of a graph that computes ``y = 2 x``."""
    x, y = (helper.make_tensor_value_info(name, TensorProto.FLOAT, [3]) for name in "xy")
    content = helper.make_graph([helper.make_node("Add", ["x", "x"], ["y"])], "twice", [x], [y])
    path = tmp_path / "twice.onnx"
    onnx.save(helper.make_model(content, opset_imports=[helper.make_opsetid("", 18)], ir_version=10), path)
    return path


@pytest.mark.parametrize("runtime", [OpenVINO(threads=1), OnnxRuntime(threads=1)], ids=lambda r: r.name)
def test_signal_stack_after_graphs_are_deleted_in_the_order_of_loading(graph, runtime):
    sessions = [runtime.load(graph) for _ in range(3)]
    while sessions:
        x = np.arange(3, dtype=np.float32)
        np.testing.assert_array_equal(sessions[0]({"x": x})["y"], 2 * x)
        del sessions[0]
        gc.collect()
        assert signal_stack_is_there()
