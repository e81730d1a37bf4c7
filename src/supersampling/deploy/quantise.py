"""Quantisation of an exported method's convolutions to int8 for OpenVINO, after training, on real frames (NNCF).

Only convolutions with fixed weights are quantised, both their inputs and their weights. Warps, blending, colour and the
state stay float32, and so do convolutions whose kernels are computed from the jitter, and a clip's first frame.
"""

import importlib.util
import json
import logging
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from supersampling.deploy.check import arrays, buffers
from supersampling.deploy.runner import Runner, digest, sidecar
from supersampling.deploy.runtimes import OpenVINO, openvino_core
from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame

CONVOLUTIONS = ("Convolution", "GroupConvolution", "ConvolutionBackpropData")
PASS_THROUGH = ("Convert", "Reshape")  # may stand between a constant and the convolution whose weights it holds
NO_WORK = ("Constant", "Parameter", "Result")
Values = dict[str, NDArray[Any]]


def missing() -> str:
    """Return why nothing can be quantised here, in one sentence; an empty string if it can."""
    installed = importlib.util.find_spec("nncf") is not None
    return "" if installed else "int8 needs NNCF, which is not installed: pip install supersampling[int8]."


def samples(path: Path, clips: Iterable[Iterable[Frame]]) -> list[Values]:
    """Return the inputs of the graph for later frames in roll-outs of an exported method over ``clips``.

    Each roll-out carries its state. If there is one, another graph computes a clip's first frame, which is left out.
    """
    runner = Runner(path, OpenVINO())
    stateless = not runner.description["state"]
    inputs = [entry["name"] for entry in runner.description["inputs"]]
    results: list[Values] = []
    for clip in clips:
        runner.reset()
        for frame in clip:
            values = {name: array for name, array in arrays(frame).items() if name in inputs}
            if stateless or runner.state:
                results.append({**values, **runner.state})
            runner(values)
    return results


def tiled(frame: Frame, size: tuple[int, int], scale: int) -> Frame:
    """Return a frame repeated side by side until it fills ``size``, the low-resolution ``(width, height)``.

    Motion keeps its length in pixels. Such frames calibrate a graph of a fixed size with data of another window size.
    """
    results = {}
    for name, values in buffers(frame).items():
        buffer = BUFFERS[name]
        if buffer.resolution != "frame":
            times = scale if buffer.resolution == "high" else 1
            width, height = size[0] * times, size[1] * times
            h, w = values.shape[-2:]
            repeated = values.repeat(1, 1, -(-height // h), -(-width // w))[..., :height, :width]
            if buffer.kind == "plane":
                repeated = repeated * values.new_tensor((w / width, h / height))[:, None, None]
            values = repeated
        results[name] = values
    return Frame(**results)


def quantise(path: Path, clips: Iterable[Iterable[Frame]]) -> Path:
    """Write ``FILE.int8.xml`` and its description beside an exported ``FILE.onnx``.

    Return its path, for a `Runner` on OpenVINO. A graph for all sizes remains one. Do not fix its size afterwards with
    OpenVINO's ``reshape``: OpenVINO 2026.4 then crashes. Export it for that size and calibrate with `tiled` frames.

    Args:
        clips: frames of training or validation data, each clip from its first frame, of a size that the graph takes.

    Raises:
        UserError: NNCF is not installed, or there are no frames or no convolution to quantise.
    """
    if reason := missing():
        raise UserError(reason)
    # NNCF would otherwise report its use over the network.
    os.environ.setdefault("NNCF_CI", "1")
    import nncf
    import openvino

    inputs = samples(path, clips)
    if not inputs:
        raise UserError("int8 needs frames to calibrate on: use training or validation clips of at least two frames.")
    description: dict[str, Any] = json.loads(sidecar(path).read_text())
    model = openvino_core().read_model(path.parent / description["graphs"]["next"])
    logging.getLogger("nncf").setLevel(logging.ERROR)
    model = nncf.quantize(
        model,
        nncf.Dataset(inputs),
        subset_size=len(inputs),
        ignored_scope=nncf.IgnoredScope(names=_unquantised(model), validate=False),
    )
    out = path.with_suffix(".int8.xml")
    openvino.save_model(model, out, compress_to_fp16=False)
    description["graphs"]["next"] = out.name
    files = {path.parent / description["graphs"]["first"], out, out.with_suffix(".bin")}
    description["digests"] = {file.name: digest(file) for file in sorted(files)}
    sidecar(out).write_text(json.dumps({**description, "precision": "int8"}, indent=2) + "\n")
    return out


def _unquantised(model: Any) -> list[str]:
    """Return the names of all operations except convolutions with fixed weights."""
    quantised = {op.get_friendly_name() for op in model.get_ops() if _has_fixed_weights(op)}
    if not quantised:
        raise UserError("This method has no convolution with fixed weights to quantise: use precision float32.")
    operations = {op.get_friendly_name() for op in model.get_ops() if op.get_type_name() not in NO_WORK}
    return sorted(operations - quantised)


def _has_fixed_weights(op: Any) -> bool:
    if op.get_type_name() not in CONVOLUTIONS:
        return False
    source = op.input_value(1).get_node()
    while source.get_type_name() in PASS_THROUGH:
        source = source.input_value(0).get_node()
    return bool(source.get_type_name() == "Constant")
