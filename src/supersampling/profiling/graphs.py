"""Backends that run an exported graph."""

import importlib.util
import tempfile
from abc import abstractmethod
from pathlib import Path
from typing import Any, final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from supersampling.deploy import describe
from supersampling.deploy.check import arrays
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO, Runtime
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.forms import precompute_kernels
from supersampling.models.precision import missing_arithmetic
from supersampling.profiling.backends import Backend, LoadOptions, Stream
from supersampling.profiling.bound import BoundStream


@final
class RunnerStream(Stream):
    """A method in a `Runner`, from arrays to an array."""

    def __init__(self, path: Path, runtime: Runtime) -> None:
        self._runner = Runner(path, runtime)

    def prepare(self, frame: Frame) -> dict[str, NDArray[np.float32]]:
        return arrays(frame)

    def step(self, prepared: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        return self._runner(prepared)

    def image(self, result: NDArray[np.float32]) -> Tensor:
        return torch.from_numpy(np.array(result, dtype=np.float32))

    def reset(self) -> None:
        self._runner.reset()

    def shapes(self) -> list[tuple[int, ...]]:
        return [tuple(values.shape) for values in self._runner.state.values()]


def write(model: Upsampler, options: LoadOptions, folder: Path) -> Path:
    """Write a method's graphs and their description as ``export.py`` does, for one size; return the path."""
    model = precompute_kernels(model, options.jitters)
    path = folder / "model.onnx"
    describe.write(path, model, export(model, (options.width, options.height)))
    return path


class GraphBackend(Backend):
    """A program that runs a graph for one size, exported into a folder that is deleted once the graph is loaded."""

    module: str  # the Python module that has to be installed

    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        with tempfile.TemporaryDirectory(prefix="benchmark") as folder:
            return self.open(write(model, options, Path(folder)), options)

    def missing(self, device: torch.device, precision: str) -> str:
        if importlib.util.find_spec(self.module) is None:
            return f"{self.name} is not installed: pip install {self.module}."
        return self.limitation(device, precision) or missing_arithmetic(device, precision)

    @abstractmethod
    def limitation(self, device: torch.device, precision: str) -> str:
        """Return why the installed program does not run on a device in a precision; an empty string if it does."""

    @abstractmethod
    def open(self, path: Path, options: LoadOptions) -> Stream:
        """Return the method whose graphs are at ``path``, ready to run."""


@final
class OnnxRuntimeBackend(GraphBackend):
    """ONNX Runtime: on the processor as in deployment; on CUDA with inputs and state left on the device."""

    name, module = "onnxruntime", "onnxruntime"

    def limitation(self, device: torch.device, precision: str) -> str:
        if precision != "float32":
            return f"ONNX Runtime runs a float32 graph in float32 only: {precision} needs a converted graph."
        return "" if device.type == "cpu" else _missing_provider("CUDAExecutionProvider", "onnxruntime-gpu")

    def open(self, path: Path, options: LoadOptions) -> Stream:
        if options.device.type == "cpu":
            return RunnerStream(path, OnnxRuntime(threads=options.threads))
        return BoundStream(path, [("CUDAExecutionProvider", {"use_tf32": 0})], options)


@final
class OpenVINOBackend(GraphBackend):
    """OpenVINO on the processor, with the precision as a hint."""

    name, module = "openvino", "openvino"
    _HINTS = {"float32": "f32", "bfloat16": "bf16", "float16": "f16"}  # noqa: RUF012

    def limitation(self, device: torch.device, precision: str) -> str:
        return "" if device.type == "cpu" else "OpenVINO does not run on CUDA."

    def open(self, path: Path, options: LoadOptions) -> Stream:
        return RunnerStream(path, OpenVINO(precision=self._HINTS[options.precision], threads=options.threads))


@final
class TensorRTBackend(GraphBackend):
    """TensorRT through ONNX Runtime, which builds its engine on the first frames; the state stays on the device."""

    name, module = "tensorrt", "onnxruntime"

    def limitation(self, device: torch.device, precision: str) -> str:
        if device.type != "cuda":
            return "TensorRT needs an NVIDIA GPU."
        if importlib.util.find_spec("tensorrt") is None:
            return "TensorRT is not installed: pip install tensorrt."
        return _missing_provider("TensorrtExecutionProvider", "onnxruntime-gpu")

    def open(self, path: Path, options: LoadOptions) -> Stream:
        types: dict[str, Any] = {
            "trt_fp16_enable": options.precision == "float16",
            "trt_bf16_enable": options.precision == "bfloat16",
        }
        return BoundStream(path, [("TensorrtExecutionProvider", types), "CUDAExecutionProvider"], options)


def _missing_provider(provider: str, package: str) -> str:
    import onnxruntime

    available = provider in onnxruntime.get_available_providers()
    return "" if available else f"This ONNX Runtime has no {provider}: pip install {package}."
