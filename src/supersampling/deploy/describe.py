"""Files of an exported method: its graphs, and a JSON description that tells an engine how to run them."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from supersampling import __version__
from supersampling.deploy.graph import IMAGE, OPSET, Axis, Graphs
from supersampling.deploy.runner import digest, sidecar
from supersampling.frames import BUFFERS, Buffer
from supersampling.models.base import Upsampler

FORMAT = 1
CONVENTIONS = {
    "layout": "batch (1), channels, rows, columns; x is right, y is down, the origin is the top-left corner",
    "sizes": "h and w are the low-resolution input's height and width",
    "first_frame": "run graphs.first at a clip's start and after every cut: it has no state inputs, and its outputs "
    "are the first state; run graphs.next for every other frame",
    "state": "hand each state output of a frame to the state input of the next frame, untouched",
    "samples": "a low-resolution pixel (i, j) is one sample at (j + 0.5 + jitter_x, i + 0.5 + jitter_y) in "
    "low-resolution pixels",
    "motion": "backward and free of jitter: where a pixel's point was in the previous frame, previous_uv = uv + "
    "motion, with uv from 0 to 1 over the whole image",
    "missing": "a graph may ignore an input on the first frame; give it all the same",
}


def write(
    path: Path,
    model: Upsampler,
    graphs: Graphs,
    jitter: Mapping[str, Any] | None = None,
    origin: Mapping[str, Any] | None = None,
) -> list[Path]:
    """Write ``FILE.onnx``, ``FILE.first.onnx`` if there is a state, and ``FILE.json``; return their paths, sorted."""
    first = path.with_suffix(".first.onnx") if graphs.state else path
    graphs.next.save(str(path))
    if graphs.state:
        graphs.first.save(str(first))
    description = describe(model, graphs, (first.name, path.name), jitter or {}, origin or {})
    description["digests"] = {file.name: digest(file) for file in sorted({first, path})}
    sidecar(path).write_text(json.dumps(description, indent=2) + "\n")
    return sorted({path, first, sidecar(path)})


def describe(
    model: Upsampler, graphs: Graphs, files: tuple[str, str], jitter: Mapping[str, Any], origin: Mapping[str, Any]
) -> dict[str, Any]:
    """Return names, shapes, units and conventions of exported graphs as plain values for JSON.

    Args:
        files: names of the first frame's graph and of the graph for all later frames.
        jitter: known facts of the jitter sequence.
        origin: further entries at the top level: method, run, ...
    """
    first, later = files
    return {
        "format": FORMAT,
        "supersampling": __version__,
        "opset": OPSET,
        **origin,
        "scale": model.scale,
        "graphs": {"first": first, "next": later},
        "size": _size(graphs),
        "inputs": [_input(BUFFERS[name], model.scale, graphs.size) for name in graphs.inputs],
        "state": [
            {"input": s.name, "output": s.output, "shape": _shape(s.axes, graphs.size), "dtype": s.dtype}
            for s in graphs.state
        ],
        "output": {
            "name": IMAGE,
            "shape": _shape((1, 3, (model.scale, "h"), (model.scale, "w")), graphs.size),
            "dtype": "float32",
            "unit": "display-referred sRGB",
            "range": "[0, 1]",
        },
        "jitter": dict(jitter),
        "conventions": CONVENTIONS,
    }


def _size(graphs: Graphs) -> dict[str, Any]:
    if graphs.size is not None:
        return {"fixed": list(graphs.size), "multiple_of": 1, "at_least": 1}
    return {"fixed": None, "multiple_of": graphs.multiple, "at_least": 2 * graphs.multiple}


def _input(buffer: Buffer, scale: int, size: tuple[int, int] | None) -> dict[str, Any]:
    times = {"low": 1, "high": scale}.get(buffer.resolution)
    axes: tuple[Axis, ...] = (1, buffer.channels)
    if times is not None:
        axes += ((times, "h"), (times, "w"))
    return {
        "name": buffer.name,
        "shape": _shape(axes, size),
        "dtype": "float32",
        "unit": buffer.unit,
        "range": buffer.range,
    }


def _shape(axes: Sequence[Axis], size: tuple[int, int] | None) -> list[int | str]:
    return [_length(axis, size) for axis in axes]


def _length(axis: Axis, size: tuple[int, int] | None) -> int | str:
    if isinstance(axis, int):
        return axis
    times, side = axis
    if size is not None:
        return times * size["wh".index(side)]
    return side if times == 1 else f"{times}*{side}"
