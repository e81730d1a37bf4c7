"""Programs that run ONNX files, each a class, behind one call."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

Values = Mapping[str, NDArray[Any]]
Session = Callable[[Values], dict[str, NDArray[Any]]]


class Runtime(ABC):
    """``load(file)`` gives what turns a graph's inputs into its outputs, both by name."""

    name: str

    @abstractmethod
    def load(self, path: Path) -> Session: ...


@final
class OnnxRuntime(Runtime):
    """ONNX Runtime on its ``providers``, the processor's by default; ``threads`` of 0 leaves their number to it."""

    name = "onnxruntime"

    def __init__(self, providers: tuple[str, ...] = ("CPUExecutionProvider",), threads: int = 0) -> None:
        self._providers, self._threads = list(providers), threads

    def load(self, path: Path) -> Session:
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = self._threads
        options.log_severity_level = 3  # errors
        session = onnxruntime.InferenceSession(str(path), options, providers=self._providers)
        names = [output.name for output in session.get_outputs()]
        return lambda values: dict(zip(names, session.run(names, dict(values))))


@cache
def openvino_core() -> Any:
    """The one core of this process, which lives as long.

    A core's processor plugin (OpenVINO 2026.4) gives the thread a stack for signals and puts the one before back at its end. Two
    cores that end in the order in which they began leave the first one's, whose memory is gone: the next signal ends the process,
    such as that of a data loader's worker.
    """
    import openvino

    return openvino.Core()


@final
class OpenVINO(Runtime):
    """OpenVINO on a ``device``; ``threads`` of 0 leaves their number to it.

    It computes in float32: its own default is half precision where the device is fast at it.
    """

    name = "openvino"

    def __init__(self, device: str = "CPU", precision: str = "f32", threads: int = 0) -> None:
        self._device = device
        self._options: dict[str, Any] = {"INFERENCE_PRECISION_HINT": precision}
        if threads:
            self._options["INFERENCE_NUM_THREADS"] = threads

    def load(self, path: Path) -> Session:
        model = openvino_core().compile_model(str(path), self._device, self._options)
        names = [output.get_any_name() for output in model.outputs]

        def run(values: Values) -> dict[str, NDArray[Any]]:
            results = model(dict(values))
            # Copies: the next call writes into the same memory.
            return {name: np.array(results[k]) for k, name in enumerate(names)}

        return run
