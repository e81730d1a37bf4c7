"""ONNX Runtime with inputs, state and image left on the device."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, final

import torch
from torch import Tensor

from supersampling.deploy.check import arrays
from supersampling.deploy.runner import sidecar
from supersampling.frames import Frame
from supersampling.profiling.backends import LoadOptions, Stream


@final
class BoundStream(Stream):
    """An exported method that passes nothing through the host's memory between frames.

    Args:
        path: the file that `supersampling.deploy.describe.write` wrote.
        providers: as `onnxruntime.InferenceSession` takes them.
    """

    def __init__(self, path: Path, providers: list[Any], options: LoadOptions) -> None:
        import onnxruntime

        description = json.loads(sidecar(path).read_text())
        session_options = onnxruntime.SessionOptions()
        session_options.intra_op_num_threads = options.threads
        session_options.log_severity_level = 3  # errors
        self._first, self._next = (
            onnxruntime.InferenceSession(str(path.parent / description["graphs"][role]), session_options, providers)
            for role in ("first", "next")
        )
        self._device = (options.device.type, options.device.index or 0)
        self._slots = [(s["input"], s["output"]) for s in description["state"]]
        self._inputs = [i["name"] for i in description["inputs"]]
        self._image: str = description["output"]["name"]
        self._state: dict[str, Any] | None = None

    def prepare(self, frame: Frame) -> dict[str, Any]:
        from onnxruntime import OrtValue

        return {k: OrtValue.ortvalue_from_numpy(v, *self._device) for k, v in arrays(frame).items()}

    def step(self, prepared: Mapping[str, Any]) -> Any:
        session = self._first if self._state is None else self._next
        input_names = {i.name for i in session.get_inputs()}  # the exporter drops inputs that a graph ignores
        binding = session.io_binding()
        for name, value in {**{k: prepared[k] for k in self._inputs}, **(self._state or {})}.items():
            if name in input_names:
                binding.bind_ortvalue_input(name, value)
        names = [o.name for o in session.get_outputs()]
        for name in names:
            binding.bind_output(name, *self._device)
        session.run_with_iobinding(binding)
        results = dict(zip(names, binding.get_outputs()))
        self._state = {name: results[output] for name, output in self._slots}
        return results[self._image]

    def image(self, result: Any) -> Tensor:
        return torch.from_numpy(result.numpy().copy()).float()

    def reset(self) -> None:
        self._state = None

    def shapes(self) -> list[tuple[int, ...]]:
        return [tuple(value.shape()) for value in (self._state or {}).values()]
