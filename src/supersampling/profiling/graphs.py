"""Backends that run an exported graph."""

import importlib.util
import json
import tempfile
from abc import abstractmethod
from pathlib import Path
from typing import Any, final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from supersampling.deploy.check import arrays
from supersampling.deploy.describe import describe
from supersampling.deploy.graph import export
from supersampling.deploy.runner import Runner, sidecar
from supersampling.deploy.runtimes import OnnxRuntime, OpenVINO, Runtime
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Backend, Precomputes, Setting, Stream
from supersampling.profiling.bound import BoundStream
from supersampling.profiling.precision import lacking


@final
class RunnerStream(Stream):
    """A `Runner`'s, from arrays to an array."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

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


def write(model: Upsampler, setting: Setting, folder: Path) -> Path:
    """The method's graphs and their description, for the setting's size alone, as ``export.py`` writes them."""
    if isinstance(model, Precomputes) and setting.jitters is not None:
        model = model.with_precomputed_kernels(setting.jitters)
    graphs = export(model, (setting.width, setting.height))
    path = folder / "model.onnx"
    first = folder / "model.first.onnx" if graphs.state else path
    graphs.other.save(str(path))
    if graphs.state:
        graphs.first.save(str(first))
    about = describe(model, graphs, (first.name, path.name), {}, {})
    sidecar(path).write_text(json.dumps(about))
    return path


class Exported(Backend):
    """A graph for one size, exported into a folder that lasts until it is loaded."""

    module: str  # that has to be installed

    def load(self, model: Upsampler, setting: Setting) -> Stream:
        with tempfile.TemporaryDirectory(prefix="benchmark") as folder:
            return self.open(write(model, setting, Path(folder)), setting)

    def missing(self, device: torch.device, precision: str) -> str:
        if importlib.util.find_spec(self.module) is None:
            return f"{self.name} is not installed: pip install {self.module}."
        return self.refused(device, precision) or lacking(device, precision)

    @abstractmethod
    def refused(self, device: torch.device, precision: str) -> str:
        """Why an installed one does not do this, one sentence; empty if it does."""

    @abstractmethod
    def open(self, path: Path, setting: Setting) -> Stream: ...


@final
class WithOnnxRuntime(Exported):
    """ONNX Runtime: on the processor as in deployment; on CUDA with inputs and state left on the device."""

    name, module = "onnxruntime", "onnxruntime"

    def refused(self, device: torch.device, precision: str) -> str:
        if precision != "float32":
            return (
                f"ONNX Runtime runs a float32 graph in float32: there is no {precision} without converting the graph."
            )
        return "" if device.type == "cpu" else _no_provider("CUDAExecutionProvider", "onnxruntime-gpu")

    def open(self, path: Path, setting: Setting) -> Stream:
        if setting.device.type == "cpu":
            return _runner(path, OnnxRuntime(threads=setting.threads))
        return BoundStream(path, [("CUDAExecutionProvider", {"use_tf32": 0})], setting)


@final
class WithOpenVINO(Exported):
    """OpenVINO on the processor, told to compute in the precision."""

    name, module = "openvino", "openvino"
    _HINTS = {"float32": "f32", "bfloat16": "bf16", "float16": "f16"}  # noqa: RUF012

    def refused(self, device: torch.device, precision: str) -> str:
        return "" if device.type == "cpu" else "OpenVINO does not run on CUDA."

    def open(self, path: Path, setting: Setting) -> Stream:
        return _runner(path, OpenVINO(precision=self._HINTS[setting.precision], threads=setting.threads))


@final
class TensorRT(Exported):
    """TensorRT through ONNX Runtime, which builds its engine on the first frames; the state stays on the device."""

    name, module = "tensorrt", "onnxruntime"

    def refused(self, device: torch.device, precision: str) -> str:
        if device.type != "cuda":
            return "TensorRT needs an NVIDIA GPU."
        if importlib.util.find_spec("tensorrt") is None:
            return "TensorRT is not installed: pip install tensorrt."
        return _no_provider("TensorrtExecutionProvider", "onnxruntime-gpu")

    def open(self, path: Path, setting: Setting) -> Stream:
        options: dict[str, Any] = {
            "trt_fp16_enable": setting.precision == "float16",
            "trt_bf16_enable": setting.precision == "bfloat16",
        }
        return BoundStream(path, [("TensorrtExecutionProvider", options), "CUDAExecutionProvider"], setting)


def _runner(path: Path, runtime: Runtime) -> RunnerStream:
    return RunnerStream(Runner(path, runtime))


def _no_provider(provider: str, package: str) -> str:
    import onnxruntime

    found = provider in onnxruntime.get_available_providers()
    return "" if found else f"This ONNX Runtime has no {provider}: pip install {package}."
