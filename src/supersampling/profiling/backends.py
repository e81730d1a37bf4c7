"""Ways to run a method frame by frame, each a class, behind one call."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Protocol, final, runtime_checkable

import torch
from torch import Tensor, nn
from torch.utils._pytree import tree_leaves

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.profiling.precision import TYPES, lacking

Clips = Callable[[Upsampler, tuple[int, int]], Iterable[Iterable[Frame]]]


@runtime_checkable
class Precomputes(Protocol):
    """A method whose kernels can be made beforehand for a jitter sequence."""

    def with_precomputed_kernels(self, jitters: Tensor) -> Upsampler: ...


@runtime_checkable
class ForInference(Protocol):
    """A method that has a faster form of equal output."""

    def for_inference(self) -> Upsampler: ...


@dataclass(frozen=True)
class Setting:
    """Where and how a method runs: the low-resolution input's size, precision, device, threads, and the jitters ``(N, 2)`` that
    come up, if it reads any."""

    width: int
    height: int
    precision: str
    device: torch.device
    threads: int
    jitters: Tensor | None = None


def deployed(model: Upsampler, setting: Setting) -> Upsampler:
    """The form of a method that is meant to be used: what can be made beforehand is, and rewrites of equal output are in."""
    if isinstance(model, Precomputes) and setting.jitters is not None:
        model = model.with_precomputed_kernels(setting.jitters)
    return model.for_inference() if isinstance(model, ForInference) else model


class Stream(ABC):
    """A method that is loaded: frames in turn, its state carried on.

    ``prepare`` brings a frame to where the backend reads it from, which a renderer would have done; ``step`` is what is timed,
    from there to the display-referred image; ``image`` gives that as ``(1, 3, H, W)`` on the processor, float32.
    """

    model: Upsampler | None = None  # whose modules are called, if they are PyTorch's

    @abstractmethod
    def prepare(self, frame: Frame) -> Any: ...

    @abstractmethod
    def step(self, prepared: Any) -> Any: ...

    @abstractmethod
    def image(self, result: Any) -> Tensor: ...

    @abstractmethod
    def reset(self) -> None:
        """The next frame is a clip's first."""

    @abstractmethod
    def shapes(self) -> list[tuple[int, ...]]:
        """Of the state's tensors, in the order in which they are carried."""


class Backend(ABC):
    """``load`` makes a method ready to run.

    ``missing`` says in one sentence why it does not run here at all, or not in this precision; it is empty where it does.
    """

    name: str

    @abstractmethod
    def missing(self, device: torch.device, precision: str) -> str: ...

    @abstractmethod
    def load(self, model: Upsampler, setting: Setting) -> Stream: ...

    def calibrated(self, clips: Clips) -> "Backend":
        """This backend; one that quantises does so by the frames that ``clips`` gives of a model and low-resolution size."""
        return self


@final
class TorchStream(Stream):
    """PyTorch's, in evaluation mode.

    In bfloat16 and float16, autocast has convolutions and matrix products computed in that type, while warps and blending stay
    float32: a state that a method blends into frame after frame stays float32, one of features has the type that the layer
    which made it gives.
    """

    def __init__(self, model: Upsampler, setting: Setting, layout: torch.memory_format, compiled: bool = False) -> None:
        self._model = model.to(setting.device).eval()
        self.model = None if compiled else self._model  # compiled code has no parts
        for module in model.modules():  # a whole model's other parameters may have more axes than a layout is for
            if isinstance(module, nn.Conv2d):
                module.to(memory_format=layout)
        self._layout, self._device, self._state = layout, setting.device, None
        self._cast = torch.autocast(
            setting.device.type, TYPES[setting.precision], enabled=setting.precision != "float32"
        )
        self._call: Any = torch.compile(self._shown, dynamic=False) if compiled else self._shown

    def prepare(self, frame: Frame) -> Frame:
        return Frame(**{k: self._placed(v) for k, v in buffers(frame).items()})

    def _placed(self, values: Tensor) -> Tensor:
        layout = self._layout if values.ndim == 4 else torch.contiguous_format
        return values.to(self._device).contiguous(memory_format=layout)

    def _shown(self, frame: Frame, state: Any) -> tuple[Tensor, Any]:
        output, state = self._model(frame, state)
        return self._model.present(output, frame), state

    # Not inference_mode: what is compiled in it is compiled again outside.
    @torch.no_grad()
    def step(self, prepared: Frame) -> Tensor:
        with self._cast:
            image, self._state = self._call(prepared, self._state)
        return image

    def image(self, result: Tensor) -> Tensor:
        return result.float().cpu().contiguous()

    def reset(self) -> None:
        self._state = None

    def shapes(self) -> list[tuple[int, ...]]:
        return [tuple(t.shape) for t in tree_leaves(self._state) if isinstance(t, Tensor)]


def buffers(frame: Frame) -> Mapping[str, Tensor]:
    """A frame's buffers that are there, by name."""
    held = {f.name: getattr(frame, f.name) for f in fields(frame)}
    return {name: values for name, values in held.items() if values is not None}


@final
class Eager(Backend):
    """PyTorch's own way, the method as it is trained."""

    name = "eager"

    def missing(self, device: torch.device, precision: str) -> str:
        return lacking(device, precision)

    def load(self, model: Upsampler, setting: Setting) -> Stream:
        return TorchStream(model, setting, torch.contiguous_format)


@final
class ChannelsLast(Backend):
    """The form for inference, images with their channels innermost, as convolutions like them."""

    name = "channels_last"

    def missing(self, device: torch.device, precision: str) -> str:
        return lacking(device, precision)

    def load(self, model: Upsampler, setting: Setting) -> Stream:
        return TorchStream(deployed(model, setting), setting, torch.channels_last)


@final
class Compile(Backend):
    """The form for inference, through `torch.compile`, for the one size."""

    name = "compile"

    def missing(self, device: torch.device, precision: str) -> str:
        if device.type == "cpu":
            from torch._inductor.cpp_builder import get_cpp_compiler
            from torch._inductor.exc import InvalidCxxCompiler

            try:
                get_cpp_compiler()
            except (InvalidCxxCompiler, RuntimeError):
                return "torch.compile needs a C++ compiler: install g++."
        elif not torch.utils._triton.has_triton():
            return "torch.compile needs Triton on this device: install triton."
        return lacking(device, precision)

    def load(self, model: Upsampler, setting: Setting) -> Stream:
        return TorchStream(deployed(model, setting), setting, torch.contiguous_format, compiled=True)
