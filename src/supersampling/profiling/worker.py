"""A process that holds one loaded method and times it when asked: its memory is its own, and so is its end."""

import gc
import math
import multiprocessing
import os
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
from supersampling.profiling import ceiling, memory
from supersampling.profiling.backends import Backend, Setting, TorchStream
from supersampling.profiling.parts import Part, Recorder, parts
from supersampling.profiling.precision import TYPES
from supersampling.profiling.stream import Streaming, cache_size, distinct_frames
from supersampling.render.jitter import jitter_sequence
from supersampling.runs.timing import architecture

LONGEST_REASON = 200  # characters
GRACE = 10  # seconds that a worker has to end by itself
_NO_MEMORY = (
    "memoryerror", "not enough memory", "can't allocate", "cannot allocate", "out of memory", "bad_alloc", "failed to allocate",
    "memory exhausted", "can't start new thread", "failed to map segment",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """What is timed: a method's resolved configuration and jitter pattern, the target's size, a backend's name and
    configuration, and a precision."""

    method: str
    model: Mapping[str, Any]
    scale: int
    jitter: str
    size: tuple[int, int]
    name: str
    backend: Mapping[str, Any]
    precision: str
    device: str
    threads: int

    @property
    def architecture(self) -> str:
        return architecture(self.model, self.scale)

    @property
    def low(self) -> tuple[int, int]:
        return self.size[0] // self.scale, self.size[1] // self.scale


class Failed(Exception):
    """A case cannot run, for a reason that is one sentence.

    ``memory`` says that it may run once more memory is free.
    """

    def __init__(self, reason: str, memory: bool = False) -> None:
        super().__init__(reason)
        self.memory = memory


class Held:
    """What the process holds: a case that runs."""

    def __init__(self, case: Case) -> None:
        self._device = torch.device(case.device)
        self._before = memory.held(self._device)
        torch.manual_seed(0)
        model: Upsampler = instantiate(dict(case.model))
        jitters = None
        if "jitter" in model.requires:
            jitters = torch.from_numpy(jitter_sequence(case.jitter, case.scale))
        backend: Backend = instantiate(dict(case.backend))
        setting = Setting(*case.low, case.precision, self._device, case.threads, jitters)
        frames = distinct_frames(model, *case.low, jitters, cache_size())
        self._stream = backend.load(model, setting)
        if isinstance(self._stream, TorchStream):  # runtimes see to it themselves
            memory.keep()
        self._streaming = Streaming(self._stream, frames, self._device)
        del model, frames
        self._streaming.warm_up()
        gc.collect()
        memory.forget_peak(self._device)

    @staticmethod
    def import_first(case: Case) -> None:
        """Libraries that lack memory while they load may wait for ever (OpenBLAS does): load them before there is a limit."""
        for target in (case.model["_target_"], case.backend["_target_"]):
            get_class(target)

    def time(self, frames: int, seconds: float) -> list[float]:
        return self._streaming.time(frames, seconds)

    def parts(self, depth: int, frames: int) -> list[Part]:
        """None where the parts are not PyTorch's modules."""
        if self._stream.model is None:
            return []
        self._streaming.step()
        return parts(self._stream.model, self._streaming.step, frames, Recorder(self._device, depth))

    def transient(self) -> float:
        """Bytes that it needs while it runs a frame, beyond what it holds between two."""
        self._streaming.step()
        return max(memory.peak(self._device) - memory.held(self._device), 0)

    def peak(self) -> float:
        """Bytes at the peak since the state had its full size, beyond what the process held before; NaN of a runtime that has a
        memory of its own on the device."""
        if self._device.type == "cuda" and not isinstance(self._stream, TorchStream):
            return math.nan
        return memory.peak(self._device) - self._before


class Ceilings:
    """What the process holds: the machine's own rates."""

    def __init__(self, device: str, precision: str) -> None:
        self._device, self._type = torch.device(device), TYPES[precision]

    def measure(self, times: int) -> ceiling.Ceiling:
        return ceiling.measure(self._device, self._type, times)


def serve(pipe: Connection, threads: int, limit: int | None, make: Any, arguments: tuple[Any, ...]) -> None:
    """A worker's life: make what it holds, then call its methods as they are asked for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the one who asks ends it
    pin(threads)
    torch.backends.cudnn.allow_tf32 = False  # float32 is float32
    torch.backends.cudnn.benchmark = True  # sizes stay
    try:
        if limit is not None:
            make.import_first(*arguments)
            memory.allow(limit)
        held = make(*arguments)
        pipe.send((True, None))
        while (asked := pipe.recv()) is not None:
            name, values = asked
            pipe.send((True, getattr(held, name)(*values)))
    except EOFError:
        pass
    except Exception as error:
        pipe.send((False, *_reason(error)))


def pin(threads: int) -> None:
    """Compute on the first so many of the cores that this process may use, one thread each."""
    torch.set_num_threads(threads)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:threads])


def _reason(error: Exception) -> tuple[str, bool]:
    text = "".join(traceback.format_exception(error))
    if isinstance(error, MemoryError) or any(sign in text.lower() for sign in _NO_MEMORY):
        return "It needs more memory than there is.", True
    known = find_user_error(error)
    said = str(error).strip().splitlines() or [""]
    return str(known) if known is not None else f"{type(error).__name__}: {said[0]}"[:LONGEST_REASON], False


class Worker:
    """The asking end. Methods of what it holds are called by `ask`, one at a time.

    Raises:
        Failed: it could not be made.
    """

    def __init__(self, threads: int, limit: int | None, make: type, *arguments: Any) -> None:
        context = multiprocessing.get_context("forkserver" if sys.platform != "win32" else "spawn")
        context.set_forkserver_preload([__name__])
        self._pipe, theirs = context.Pipe()
        make_process: Any = context.Process  # type: ignore[attr-defined]
        self._process = make_process(target=serve, args=(theirs, threads, limit, make, arguments), daemon=True)
        self._process.start()
        theirs.close()
        try:
            self._answer()
        except Failed:
            self.close()
            raise

    def ask(self, name: str, *values: Any) -> Any:
        """What the method gives.

        Raises:
            Failed: it raised, or the process is gone; the worker is of no further use.
        """
        try:
            self._pipe.send((name, values))
        except OSError as error:
            raise self._gone() from error
        return self._answer()

    def _answer(self) -> Any:
        try:
            well, *result = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise self._gone() from error
        if not well:
            raise Failed(*result)
        return result[0]

    def _gone(self) -> Failed:
        self._process.join(10)
        code = self._process.exitcode
        return Failed(f"Its process was ended from outside (exit code {code}), as for want of memory.", True)

    def close(self) -> None:
        """End the process; its memory is free then."""
        with suppress(OSError):
            self._pipe.send(None)
        self._process.join(GRACE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._pipe.close()
