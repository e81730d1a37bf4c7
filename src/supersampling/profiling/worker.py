"""Worker processes: each loads one method and times it on request, so that its memory is measured and freed alone."""

import gc
import math
import multiprocessing
import os
import re
import signal
import sys
import traceback
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

import torch
from hydra.utils import get_class, instantiate

from supersampling.errors import find_user_error
from supersampling.models.base import Upsampler
from supersampling.models.precision import TYPES
from supersampling.profiling import ceiling, memory
from supersampling.profiling.backends import Backend, LoadOptions, TorchStream
from supersampling.profiling.parts import Part, Recorder, measure_parts
from supersampling.profiling.stream import Streaming, cache_size, distinct_frames
from supersampling.render.jitter import jitter_sequence
from supersampling.runs.timing import architecture

LONGEST_REASON = 200  # characters
GRACE = 10  # seconds that a worker has to end by itself
_NO_MEMORY = re.compile(
    "memoryerror|not enough memory|can't allocate|cannot allocate|out of memory|bad_alloc|failed to allocate|"
    "memory exhausted|can't start new thread|failed to map segment"
)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A method at a target size under a backend and a precision.

    Attributes:
        method: name to show.
        model: the method's resolved configuration.
        jitter: jitter pattern.
        size: width and height of the target, pixels.
        backend: name of the backend, ``backend_config`` its configuration.
    """

    method: str
    model: Mapping[str, Any]
    scale: int
    jitter: str
    size: tuple[int, int]
    backend: str
    backend_config: Mapping[str, Any]
    precision: str
    device: str
    threads: int

    @property
    def architecture(self) -> str:
        return architecture(self.model, self.scale)

    @property
    def low_resolution(self) -> tuple[int, int]:
        return self.size[0] // self.scale, self.size[1] // self.scale


class CaseError(Exception):
    """A case cannot run, for a reason of one sentence.

    If ``memory`` is True, it may run once more memory is free.
    """

    def __init__(self, reason: str, memory: bool = False) -> None:
        super().__init__(reason)
        self.memory = memory


class LoadedCase:
    """A case that is ready to be timed, in its worker process."""

    def __init__(self, case: Case) -> None:
        self._device = torch.device(case.device)
        self._before = memory.usage(self._device)
        torch.manual_seed(0)
        model: Upsampler = instantiate(dict(case.model))
        jitters = None
        if "jitter" in model.requires:
            jitters = torch.from_numpy(jitter_sequence(case.jitter, case.scale))
        backend: Backend = instantiate(dict(case.backend_config))
        width, height = case.low_resolution
        options = LoadOptions(
            width=width,
            height=height,
            precision=case.precision,
            device=self._device,
            threads=case.threads,
            jitters=jitters,
        )
        frames = distinct_frames(model, width, height, jitters, cache_size())
        self._stream = backend.load(model, options)
        if isinstance(self._stream, TorchStream):  # runtimes retain their memory by themselves
            memory.retain_freed()
        self._streaming = Streaming(self._stream, frames, self._device)
        del model, frames
        self._streaming.warm_up()
        gc.collect()
        memory.reset_peak(self._device)

    @staticmethod
    def preload(case: Case) -> None:
        """Load libraries before memory is limited: without enough memory some (OpenBLAS) wait for ever."""
        for target in (case.model["_target_"], case.backend_config["_target_"]):
            get_class(target)

    def time(self, frames: int, seconds: float) -> list[float]:
        return self._streaming.time(frames, seconds)

    def parts(self, depth: int, frames: int) -> list[Part]:
        """Return the time of each part of the method; an empty list if the parts are not PyTorch's modules."""
        if self._stream.model is None:
            return []
        self._streaming.step()
        return measure_parts(self._stream.model, self._streaming.step, frames, Recorder(self._device, depth))

    def transient(self) -> float:
        """Return the bytes that a frame needs while it is computed, beyond those that remain between frames."""
        self._streaming.step()
        return max(memory.peak(self._device) - memory.usage(self._device), 0)

    def peak(self) -> float:
        """Return the bytes at the peak since the state had its full size, less those before the method was loaded.

        NaN for a runtime that has its own memory on the device.
        """
        if self._device.type == "cuda" and not isinstance(self._stream, TorchStream):
            return math.nan
        return memory.peak(self._device) - self._before


class CeilingMeter:
    """Measurement of the machine's highest rates, in its worker process."""

    def __init__(self, device: str, precision: str) -> None:
        self._device, self._type = torch.device(device), TYPES[precision]

    def measure(self, times: int) -> ceiling.Ceiling:
        return ceiling.measure(self._device, self._type, times)


def serve(pipe: Connection, threads: int, limit: int | None, make: Any, arguments: tuple[Any, ...]) -> None:
    """Run a worker process: create an object, then call its methods on request until the request is None."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent process ends this one
    pin(threads)
    torch.backends.cudnn.allow_tf32 = False  # float32 means float32
    torch.backends.cudnn.benchmark = True  # sizes do not change
    try:
        if limit is not None:
            make.preload(*arguments)
            memory.limit_growth(limit)
        instance = make(*arguments)
        pipe.send((True, None))
        while (request := pipe.recv()) is not None:
            name, values = request
            pipe.send((True, getattr(instance, name)(*values)))
    except EOFError:
        pass
    except Exception as error:
        pipe.send((False, *_reason(error)))


def pin(threads: int) -> None:
    """Compute with one thread on each of the first ``threads`` cores that this process may use."""
    torch.set_num_threads(threads)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])


def _reason(error: Exception) -> tuple[str, bool]:
    """Return an error as one sentence, and whether it is for lack of memory."""
    text = "".join(traceback.format_exception(error))
    if isinstance(error, MemoryError) or _NO_MEMORY.search(text.lower()):
        return "It needs more memory than there is.", True
    known = find_user_error(error)
    lines = str(error).strip().splitlines() or [""]
    return str(known) if known is not None else f"{type(error).__name__}: {lines[0]}"[:LONGEST_REASON], False


class Worker:
    """The parent's end of a worker process, whose object's methods it calls, one at a time.

    Raises:
        CaseError: the object could not be created.
    """

    def __init__(self, threads: int, limit: int | None, make: type, *arguments: Any) -> None:
        context = multiprocessing.get_context("forkserver" if sys.platform != "win32" else "spawn")
        context.set_forkserver_preload([__name__])
        self._pipe, child_pipe = context.Pipe()
        make_process: Any = context.Process  # type: ignore[attr-defined]
        self._process = make_process(target=serve, args=(child_pipe, threads, limit, make, arguments), daemon=True)
        self._process.start()
        child_pipe.close()
        try:
            self._receive()
        except CaseError:
            self.close()
            raise

    def call(self, name: str, *values: Any) -> Any:
        """Return the result of a method of the object.

        Raises:
            CaseError: the method raised, or the process has ended; the worker is of no further use.
        """
        try:
            self._pipe.send((name, values))
        except OSError as error:
            raise self._end_error() from error
        return self._receive()

    def _receive(self) -> Any:
        try:
            success, *result = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise self._end_error() from error
        if not success:
            raise CaseError(*result)
        return result[0]

    def _end_error(self) -> CaseError:
        self._process.join(GRACE)
        code = self._process.exitcode
        return CaseError(f"Its process was ended from outside (exit code {code}), probably for lack of memory.", True)

    def close(self) -> None:
        """End the process, which frees its memory."""
        with suppress(OSError):
            self._pipe.send(None)
        self._process.join(GRACE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()
