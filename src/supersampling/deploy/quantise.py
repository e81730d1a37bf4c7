"""An exported method with its convolutions in int8, for OpenVINO, quantised after training on real frames (NNCF).

Only convolutions with fixed weights are quantised, their inputs and their weights: warps, blending, colour and the state stay
float32, and so do convolutions whose kernels are made from the jitter, and a clip's first frame.
"""

import importlib.util
import json
import logging
import os
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from torch import Tensor

from supersampling.deploy.check import arrays
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OpenVINO, openvino_core
from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame

CONVOLUTIONS = ("Convolution", "GroupConvolution", "ConvolutionBackpropData")
PASSED_ON = ("Convert", "Reshape")  # between a constant and the convolution whose weights it is
NO_WORK = ("Constant", "Parameter", "Result")
Values = dict[str, NDArray[Any]]


def missing() -> str:
    """Why nothing can be quantised here, one sentence; empty if it can."""
    found = importlib.util.find_spec("nncf") is not None
    return "" if found else "int8 needs NNCF, which is not installed: pip install supersampling[int8]."


def buffers(frame: Frame) -> dict[str, Tensor]:
    """A frame's buffers that are there, by name."""
    held = {f.name: getattr(frame, f.name) for f in fields(frame)}
    return {name: values for name, values in held.items() if values is not None}


def samples(path: Path, clips: Iterable[Iterable[Frame]]) -> list[Values]:
    """What the graph of every frame but the first is given when an exported method rolls over ``clips``, its state carried."""
    runner = Runner(path, OpenVINO())
    stateless = not runner.description["state"]
    inputs = [entry["name"] for entry in runner.description["inputs"]]
    given: list[Values] = []
    for clip in clips:
        runner.reset()
        for frame in clip:
            held = {name: values for name, values in arrays(frame).items() if name in inputs}
            if stateless or runner.state:
                given.append({**held, **runner.state})
            runner(held)
    return given


def tiled(frame: Frame, size: tuple[int, int], scale: int) -> Frame:
    """A frame side by side with itself until it fills ``size``, low-resolution ``(width, height)``; motion keeps its
    pixels.

    What a graph of one size is calibrated with, where the data have windows of another.
    """
    made = {}
    for name, values in buffers(frame).items():
        kind = BUFFERS[name]
        if kind.resolution != "frame":
            times = scale if kind.resolution == "high" else 1
            width, height = size[0] * times, size[1] * times
            h, w = values.shape[-2:]
            repeated = values.repeat(1, 1, -(-height // h), -(-width // w))[..., :height, :width]
            if kind.kind == "plane":
                repeated = repeated * values.new_tensor((w / width, h / height))[:, None, None]
            values = repeated
        made[name] = values
    return Frame(**made)


def quantise(path: Path, clips: Iterable[Iterable[Frame]]) -> Path:
    """Write ``FILE.int8.xml`` and its description beside an exported ``FILE.onnx``; gives its path, for a `Runner` on OpenVINO.

    A graph for any size stays one. To fix its size afterwards (OpenVINO's ``reshape``) is no use: OpenVINO 2026.4 then crashes.
    Export it for that size instead and calibrate with `tiled` frames.

    Args:
        clips: frames from each clip's first one on, of training or validation data, of a size that the graph takes.

    Raises:
        UserError: NNCF is not installed, no frames, or no convolution to quantise.
    """
    if reason := missing():
        raise UserError(reason)
    os.environ.setdefault("NNCF_CI", "1")  # it would report its use over the network
    import nncf
    import openvino

    given = samples(path, clips)
    if not given:
        raise UserError("int8 needs frames to calibrate on: name training or validation clips of two frames or more.")
    description: dict[str, Any] = json.loads(sidecar(path).read_text())
    model = openvino_core().read_model(path.parent / description["graphs"]["next"])
    others = _left_in_float(model)
    logging.getLogger("nncf").setLevel(logging.ERROR)
    model = nncf.quantize(
        model,
        nncf.Dataset(given),
        subset_size=len(given),
        ignored_scope=nncf.IgnoredScope(names=others, validate=False),
    )
    out = path.with_suffix(".int8.xml")
    openvino.save_model(model, out, compress_to_fp16=False)
    description["graphs"]["next"] = out.name
    sidecar(out).write_text(json.dumps({**description, "precision": "int8"}, indent=2) + "\n")
    return out


def _left_in_float(model: Any) -> list[str]:
    """The names of all operations but the convolutions of fixed weights."""
    quantised = {op.get_friendly_name() for op in model.get_ops() if _has_fixed_weights(op)}
    if not quantised:
        raise UserError("This method has no convolution of fixed weights: there is nothing to quantise.")
    every = {op.get_friendly_name() for op in model.get_ops() if op.get_type_name() not in NO_WORK}
    return sorted(every - quantised)


def _has_fixed_weights(op: Any) -> bool:
    if op.get_type_name() not in CONVOLUTIONS:
        return False
    source = op.input_value(1).get_node()
    while source.get_type_name() in PASSED_ON:
        source = source.input_value(0).get_node()
    return bool(source.get_type_name() == "Constant")
