"""Time of a frame by parts: modules, the model's own methods and tensor functions, as they call each other."""

import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import wraps
from statistics import fmean
from types import FunctionType
from typing import Any
from unittest.mock import patch

import torch
from torch import nn

from supersampling.models.base import Upsampler
from supersampling.profiling.ceiling import synchronise
from supersampling.profiling.stream import Clock, spread

REST, WHOLE = "(its own)", "total"
Path = tuple[str, ...]
Seconds = dict[Path, float]


@dataclass(frozen=True, kw_only=True)
class Part:
    """A part's time in a frame, milliseconds, and its share of the frame.

    ``ms`` is the mean over the middle half of the frames, by their whole time; ``low`` and ``high`` are the quartiles
    over all frames. The dotted name ``part`` begins with the parts that call it.
    """

    part: str
    kind: str
    ms: float
    low: float
    high: float
    share: float


class Recorder:
    """Sum of the time within nested calls by the path of names that leads to them, at most ``depth`` names."""

    def __init__(self, device: torch.device, depth: int, clock: Clock = time.perf_counter) -> None:
        self._device, self._depth, self._clock = device, depth, clock
        self._path: Path = ()
        self._active = False
        self.seconds: Seconds = defaultdict(float)
        self.kinds: dict[Path, str] = {(): ""}

    def _now(self) -> float:
        synchronise(self._device)
        return self._clock()

    def frame(self, step: Callable[[], object]) -> Seconds:
        """Return the seconds within one call of ``step`` by path; the empty path is the whole call."""
        self.seconds, self._active = defaultdict(float), True
        try:
            start = self._now()
            step()
            self.seconds[()] = self._now() - start
        finally:
            self._active = False
        return self.seconds

    def record(self, name: str, kind: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return ``function`` with its calls recorded as a part called ``name``."""

        @wraps(function)
        def timed(*args: Any, **kwargs: Any) -> Any:
            if not self._active or len(self._path) >= self._depth:
                return function(*args, **kwargs)
            outer, path = self._path, (*self._path, name)
            self.kinds[path], self._path = kind, path
            start = self._now()
            try:
                return function(*args, **kwargs)
            finally:
                self.seconds[path] += self._now() - start
                self._path = outer

        return timed


@contextmanager
def recording(model: Upsampler, recorder: Recorder) -> Iterator[None]:
    """Record a model's calls of its modules, of its own methods and of `supersampling.ops` as parts."""
    with ExitStack() as undo:
        for name, module in _modules(model):
            timed = recorder.record(name, type(module).__name__, module.forward)
            undo.enter_context(patch.object(module, "forward", timed))
        for name, kind, function in _methods(model):
            undo.enter_context(patch.object(model, name, recorder.record(name, kind, function)))
        for namespace, name, function in _functions(model):
            undo.enter_context(patch.object(namespace, name, recorder.record(name, "function", function)))
        yield


def _modules(module: nn.Module) -> Iterator[tuple[str, nn.Module]]:
    """Yield modules with their names within the module that calls them; a list of modules calls none."""
    for name, child in module.named_children():
        if not isinstance(child, nn.ModuleList):
            yield name, child
            yield from _modules(child)
            continue
        for index, item in child.named_children():
            yield f"{name}.{index}", item
            yield from _modules(item)


def _methods(model: Upsampler) -> Iterator[tuple[str, str, Any]]:
    """Yield the methods that a model's classes add to those of `Upsampler`."""
    shared = set(dir(Upsampler))
    for name in {n for c in type(model).__mro__ for n, v in vars(c).items() if isinstance(v, FunctionType)}:
        if name not in shared:
            yield name, "method", getattr(model, name)


def _functions(model: Upsampler) -> Iterator[tuple[Any, str, Any]]:
    """Yield tensor functions with each module and name under which a model's modules call them."""
    for used in {c.__module__ for m in model.modules() for c in type(m).__mro__}:
        if not used.startswith("supersampling."):
            continue
        for name, value in list(vars(sys.modules[used]).items()):
            if isinstance(value, FunctionType) and value.__module__.startswith("supersampling.ops."):
                yield sys.modules[used], name, value


def measure_parts(model: Upsampler, step: Callable[[], object], frames: int, recorder: Recorder) -> list[Part]:
    """Return the time of each part of a step.

    The parts of each level are followed by the time that none of them takes. A level adds up to the part that calls it,
    since all means are over the same frames.
    """
    with recording(model, recorder):
        samples = [recorder.frame(step) for _ in range(frames)]
    middle = sorted(samples, key=lambda frame: frame[()])[frames // 4 : frames - frames // 4]
    rows: list[Part] = []

    def add(name: str, kind: str, seconds: Callable[[Seconds], float]) -> None:
        ms, all_ms = (fmean(1e3 * seconds(f) for f in middle), spread([1e3 * seconds(f) for f in samples]))
        share = ms / whole if whole else 0.0
        rows.append(Part(part=name, kind=kind, ms=ms, low=all_ms.low, high=all_ms.high, share=share))

    def walk(path: Path) -> None:
        children = [p for p in recorder.kinds if len(p) == len(path) + 1 and p[:-1] == path]
        for child in children:
            add(".".join(child), recorder.kinds[child], lambda f, c=child: f[c])  # type: ignore[misc]
            walk(child)
        if children or not path:
            add(".".join((*path, REST)), "", lambda f: f[path] - sum(f[c] for c in children))

    whole = fmean(1e3 * f[()] for f in middle)
    walk(())
    add(WHOLE, type(model).__name__, lambda f: f[()])
    return rows
