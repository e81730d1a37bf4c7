"""Runtimes for ONNX files: one class per program, one interface for all."""

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
    """A program that runs ONNX files."""

    name: str

    @abstractmethod
    def load(self, path: Path) -> Session:
        """Return a function from a graph's inputs to its outputs, both by name."""


@final
class OnnxRuntime(Runtime):
    """ONNX Runtime on its ``providers``, by default the processor; ``threads=0`` lets it choose their number."""

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
    """Return the only OpenVINO core of this process, which lives as long as the process.

    A core's processor plugin (OpenVINO 2026.4) gives the thread a stack for signals and restores the previous stack
    when the core is destroyed. If two cores are destroyed in the order of their creation, the thread is left with the
    first one's stack, whose memory is freed. The next signal, such as one from a data loader's worker, then ends the
    process.
    """
    import openvino

    return openvino.Core()


@final
class OpenVINO(Runtime):
    """OpenVINO on a ``device``; ``threads=0`` lets it choose their number.

    It computes in float32 by default. OpenVINO's own default is half precision on devices that are fast at it.
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
            # Copy: the next call writes into the same memory.
            return {name: np.array(results[k]) for k, name in enumerate(names)}

        return run
