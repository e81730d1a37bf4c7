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
from supersampling.profiling.backends import Setting, Stream


@final
class BoundStream(Stream):
    """Graphs as `write` leaves them; between frames nothing passes through the host's memory.

    Args:
        providers: as `onnxruntime.InferenceSession` takes them.
    """

    def __init__(self, path: Path, providers: list[Any], setting: Setting) -> None:
        import onnxruntime

        about = json.loads(sidecar(path).read_text())
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = setting.threads
        options.log_severity_level = 3  # errors
        self._first, self._next = (
            onnxruntime.InferenceSession(str(path.parent / about["graphs"][role]), options, providers)
            for role in ("first", "next")
        )
        self._place = (setting.device.type, setting.device.index or 0)
        self._slots = [(s["input"], s["output"]) for s in about["state"]]
        self._inputs = [i["name"] for i in about["inputs"]]
        self._image: str = about["output"]["name"]
        self._state: dict[str, Any] | None = None

    def prepare(self, frame: Frame) -> dict[str, Any]:
        from onnxruntime import OrtValue

        return {k: OrtValue.ortvalue_from_numpy(v, *self._place) for k, v in arrays(frame).items()}

    def step(self, prepared: Mapping[str, Any]) -> Any:
        session = self._first if self._state is None else self._next
        taken = {i.name for i in session.get_inputs()}  # an exporter drops what a graph ignores
        binding = session.io_binding()
        for name, value in {**{k: prepared[k] for k in self._inputs}, **(self._state or {})}.items():
            if name in taken:
                binding.bind_ortvalue_input(name, value)
        names = [o.name for o in session.get_outputs()]
        for name in names:
            binding.bind_output(name, *self._place)
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
