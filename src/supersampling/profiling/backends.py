"""Backends: ways to run a method frame by frame, one class each, with one interface."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, final

import torch
from torch import Tensor, nn
from torch.utils._pytree import tree_leaves

from supersampling.deploy.check import buffers
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.forms import optimise
from supersampling.models.precision import autocast, missing_arithmetic

# From a method and its low-resolution (width, height) to clips of frames.
Clips = Callable[[Upsampler, tuple[int, int]], Iterable[Iterable[Frame]]]


@dataclass(frozen=True, kw_only=True)
class LoadOptions:
    """Size of the low-resolution input, precision, device and threads that a method is loaded for.

    ``jitters`` ``(N, 2)`` is the jitter sequence of a method that reads one, else None.
    """

    width: int
    height: int
    precision: str
    device: torch.device
    threads: int
    jitters: Tensor | None = None


class Stream(ABC):
    """A loaded method that computes one frame after another and carries its state."""

    model: Upsampler | None = None  # the method whose modules `step` calls; None if PyTorch does not run them

    @abstractmethod
    def prepare(self, frame: Frame) -> Any:
        """Bring a frame to where the backend reads it from, which a renderer would have done; not timed."""

    @abstractmethod
    def step(self, prepared: Any) -> Any:
        """Compute the display-referred image of the next frame; this is timed."""

    @abstractmethod
    def image(self, result: Any) -> Tensor:
        """Return the image of a step as ``(1, 3, H, W)``, float32, on the processor."""

    @abstractmethod
    def reset(self) -> None:
        """Forget the state: the next frame is the first of a clip."""

    @abstractmethod
    def shapes(self) -> list[tuple[int, ...]]:
        """Return the shapes of the state's tensors in the order in which they are carried."""


class Backend(ABC):
    """A way to run a method."""

    name: str

    @abstractmethod
    def missing(self, device: torch.device, precision: str) -> str:
        """Return why this backend does not run on a device in a precision: one sentence, empty if it does."""

    @abstractmethod
    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        """Return a method that is ready to run."""

    def with_calibration(self, clips: Clips) -> "Backend":
        """Return a backend that quantises with the frames of ``clips``; this backend if it does not quantise."""
        return self


@final
class TorchStream(Stream):
    """A method that PyTorch runs in evaluation mode.

    In bfloat16 and float16, autocast computes convolutions and matrix products in that type. Warps and blending remain
    float32: a state that a method blends into frame after frame is float32, and a state of features has the type that
    its layer returns.
    """

    def __init__(
        self, model: Upsampler, options: LoadOptions, layout: torch.memory_format, compiled: bool = False
    ) -> None:
        self._model = model.to(options.device).eval()
        self.model = None if compiled else self._model  # compiled code has no parts
        # Only convolutions: other parameters of a model may have more axes than a layout allows.
        for module in model.modules():
            if isinstance(module, nn.Conv2d):
                module.to(memory_format=layout)
        self._layout, self._device, self._state = layout, options.device, None
        self._autocast = autocast(options.device.type, options.precision)
        self._call: Any = torch.compile(self._present_next, dynamic=False) if compiled else self._present_next

    def prepare(self, frame: Frame) -> Frame:
        return Frame(**{name: self._place(values) for name, values in buffers(frame).items()})

    def _place(self, values: Tensor) -> Tensor:
        layout = self._layout if values.ndim == 4 else torch.contiguous_format
        return values.to(self._device).contiguous(memory_format=layout)

    def _present_next(self, frame: Frame, state: Any) -> tuple[Tensor, Any]:
        output, state = self._model(frame, state)
        return self._model.present(output, frame), state

    # Not inference_mode: code that is compiled inside of it is compiled again outside.
    @torch.no_grad()
    def step(self, prepared: Frame) -> Tensor:
        with self._autocast:
            image, self._state = self._call(prepared, self._state)
        return image

    def image(self, result: Tensor) -> Tensor:
        return result.float().cpu().contiguous()

    def reset(self) -> None:
        self._state = None

    def shapes(self) -> list[tuple[int, ...]]:
        return [tuple(t.shape) for t in tree_leaves(self._state) if isinstance(t, Tensor)]


@final
class Eager(Backend):
    """PyTorch's eager mode; the method as it is trained."""

    name = "eager"

    def missing(self, device: torch.device, precision: str) -> str:
        return missing_arithmetic(device, precision)

    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        return TorchStream(model, options, torch.contiguous_format)


@final
class ChannelsLast(Backend):
    """PyTorch's eager mode; the form for inference, images with channels innermost, which is fast for convolutions."""

    name = "channels_last"

    def missing(self, device: torch.device, precision: str) -> str:
        return missing_arithmetic(device, precision)

    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        return TorchStream(optimise(model, options.jitters), options, torch.channels_last)


@final
class Compile(Backend):
    """`torch.compile`; the form for inference, for one size only."""

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
        return missing_arithmetic(device, precision)

    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        return TorchStream(optimise(model, options.jitters), options, torch.contiguous_format, compiled=True)
