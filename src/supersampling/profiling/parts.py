"""What a frame's time is made of: modules, the model's own methods, and tensor functions, as they call each other."""

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

OWN, WHOLE = "(its own)", "total"
Path = tuple[str, ...]
Spent = dict[Path, float]


@dataclass(frozen=True)
class Part:
    """A part's time in a frame, milliseconds: the mean over the middle half of the frames, by their whole time, and the quartiles
    over all; and its share of the frame. What calls it is in its dotted name."""

    part: str
    kind: str
    ms: float
    low: float
    high: float
    share: float


class Recorder:
    """Adds up the time within nested calls, by the names that lead to them, down to ``depth`` of these."""

    def __init__(self, device: torch.device, depth: int, clock: Clock = time.perf_counter) -> None:
        self._device, self._depth, self._clock = device, depth, clock
        self._path: Path = ()
        self._active = False
        self.spent: Spent = defaultdict(float)
        self.kinds: dict[Path, str] = {(): ""}

    def _now(self) -> float:
        synchronise(self._device)
        return self._clock()

    def frame(self, step: Callable[[], object]) -> Spent:
        """Seconds by path within one call of ``step``; the empty path is the whole."""
        self.spent, self._active = defaultdict(float), True
        try:
            began = self._now()
            step()
            self.spent[()] = self._now() - began
        finally:
            self._active = False
        return self.spent

    def recorded(self, name: str, kind: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """``function``, whose calls are a part of that name."""

        @wraps(function)
        def timed(*args: Any, **kwargs: Any) -> Any:
            if not self._active or len(self._path) >= self._depth:
                return function(*args, **kwargs)
            outer, path = self._path, (*self._path, name)
            self.kinds[path], self._path = kind, path
            began = self._now()
            try:
                return function(*args, **kwargs)
            finally:
                self.spent[path] += self._now() - began
                self._path = outer

        return timed


@contextmanager
def recording(model: Upsampler, recorder: Recorder) -> Iterator[None]:
    """Within, a model's calls of its modules, of its own methods and of `supersampling.ops` are parts."""
    with ExitStack() as undo:
        for name, module in _modules(model):
            timed = recorder.recorded(name, type(module).__name__, module.forward)
            undo.enter_context(patch.object(module, "forward", timed))
        for name, kind, function in _methods(model):
            undo.enter_context(patch.object(model, name, recorder.recorded(name, kind, function)))
        for owner, name, function in _functions(model):
            undo.enter_context(patch.object(owner, name, recorder.recorded(name, "function", function)))
        yield


def _modules(module: nn.Module) -> Iterator[tuple[str, nn.Module]]:
    """Modules by their names within what calls them, which a list does not."""
    for name, child in module.named_children():
        if not isinstance(child, nn.ModuleList):
            yield name, child
            yield from _modules(child)
            continue
        for inner, module_of_list in _modules(child):
            yield f"{name}.{inner}" if inner in child._modules else inner, module_of_list


def _methods(model: Upsampler) -> Iterator[tuple[str, str, Any]]:
    """Methods that a model's own classes add to what every upsampler has."""
    shared = set(dir(Upsampler))
    for name in {n for c in type(model).__mro__ for n, v in vars(c).items() if isinstance(v, FunctionType)}:
        if name not in shared:
            yield name, "method", getattr(model, name)


def _functions(model: Upsampler) -> Iterator[tuple[Any, str, Any]]:
    """Tensor functions by each name that a model's modules call them by."""
    for used in {c.__module__ for m in model.modules() for c in type(m).__mro__}:
        if not used.startswith("supersampling."):
            continue
        for name, value in list(vars(sys.modules[used]).items()):
            if isinstance(value, FunctionType) and value.__module__.startswith("supersampling.ops."):
                yield sys.modules[used], name, value


def parts(model: Upsampler, step: Callable[[], object], frames: int, recorder: Recorder) -> list[Part]:
    """What a step's time is made of.

    The parts of each level are followed by what is in none of them; all of a level adds up to what calls it, as means over the
    same frames do.
    """
    with recording(model, recorder):
        seen = [recorder.frame(step) for _ in range(frames)]
    middle = sorted(seen, key=lambda frame: frame[()])[frames // 4 : frames - frames // 4]
    rows: list[Part] = []

    def add(name: str, kind: str, seconds: Callable[[Spent], float]) -> None:
        ms, all_ms = (fmean(1e3 * seconds(f) for f in middle), spread([1e3 * seconds(f) for f in seen]))
        share = ms / whole if whole else 0.0
        rows.append(Part(name, kind, ms, all_ms.low, all_ms.high, share))

    def walk(path: Path) -> None:
        children = [p for p in recorder.kinds if len(p) == len(path) + 1 and p[:-1] == path]
        for child in children:
            add(".".join(child), recorder.kinds[child], lambda f, c=child: f[c])  # type: ignore[misc]
            walk(child)
        if children or not path:
            add(".".join((*path, OWN)), "", lambda f: f[path] - sum(f[c] for c in children))

    whole = fmean(1e3 * f[()] for f in middle)
    walk(())
    add(WHOLE, type(model).__name__, lambda f: f[()])
    return rows
