"""Where a training step's time goes: every operation's own time by phase and part, of a profile."""

import os
import statistics
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import wraps
from typing import Any
from unittest.mock import patch

import torch
from case import Case
from torch.autograd import DeviceType
from torch.profiler import ProfilerActivity, profile, record_function

from supersampling.ops import chain, resample, warp
from supersampling.stages import dilate, motion_grid, pad, reproject, upsample, warp_at

os.environ.setdefault("KINETO_LOG_LEVEL", "9")  # the profiler writes a line for each start and stop

PROFILED = 5
PHASES = ("forward", "loss", "backward", "optimiser")
PARTS = ("convolutions", "matrix products", "warp", "rest of network", "loss", "optimiser")
PRODUCTS = ("aten::linear", "aten::matmul", "aten::mm", "aten::addmm", "aten::bmm", "aten::baddbmm")
WARPS = (chain.chain, warp.warp, warp.outside, warp.sampling_grid, resample.jitter_aligned_upsample,
         resample.zero_upsample, resample.upsample_motion)  # fmt: skip
WARPING_STAGES = {m.__name__ for m in (dilate, motion_grid, pad, reproject, upsample, warp_at)}


@dataclass(frozen=True)
class Spent:
    """Microseconds of a step: by ``(phase, part)``, and by ``(part, operation)``."""

    cells: Counter[tuple[str, str]]
    operations: Counter[tuple[str, str]]

    def share(self, phase: str | None = None, part: str | None = None) -> float:
        chosen = (v for (a, b), v in self.cells.items() if phase in (None, a) and part in (None, b))
        return sum(chosen) / self.cells.total()

    def largest(self, part: str) -> str:
        """The five operations that cost most of a part, backward ones by themselves."""
        own = Counter({op: v for (p, op), v in self.operations.items() if p == part})
        return ", ".join(f"{op} {100 * v / self.cells.total():.0f}%" for op, v in own.most_common(5))


def warping_places(model: torch.nn.Module) -> list[tuple[Any, str]]:
    """Where warps and upsampling are called: the stages of a model, and functions wherever they were imported."""
    stages = [(m, "forward") for m in model.modules() if type(m).__module__ in WARPING_STAGES]
    loaded = [m for name, m in sys.modules.items() if name.startswith("supersampling.")]
    functions = [(m, name) for m in loaded for name, value in vars(m).items() if any(value is w for w in WARPS)]
    return [*stages, *functions]


def where_it_goes(case: Case) -> Spent:
    """Medians over `PROFILED` steps."""
    with marked("warp", warping_places(case.model)):
        steps = [_one_step(case) for _ in range(PROFILED + 1)][1:]
    cells, operations = ([getattr(step, name) for step in steps] for name in ("cells", "operations"))
    return Spent(_medians(cells), _medians(operations))


def _medians(steps: list[Counter[tuple[str, str]]]) -> Counter[tuple[str, str]]:
    return Counter({key: statistics.median(step[key] for step in steps) for key in set().union(*steps)})


def _one_step(case: Case) -> Spent:
    """Every operation's own time, by the phase it ran in and the part of the step that it, or what it derives, belongs to."""
    on_device = case.device.type == "cuda"
    activities = [ProfilerActivity.CPU, *([ProfilerActivity.CUDA] if on_device else [])]
    with profile(activities=activities) as profiler:
        case.step()
    events = [e for e in profiler.events() if e.device_type == DeviceType.CPU]
    cells: Counter = Counter()
    operations: Counter = Counter()
    part_of_node: dict[int, str] = {}
    for event in sorted(events, key=lambda e: e.time_range.start):
        lineage = [event]
        while (parent := lineage[-1].cpu_parent) is not None:
            lineage.append(parent)
        nodes = [e for e in lineage if e.name.startswith("autograd::engine")]
        phase, part = _forward_place({e.name for e in lineage})
        if nodes:  # an accelerator's backward has a thread of its own, outside the range
            phase, part = "backward", part_of_node.get(nodes[-1].sequence_nr, part)
        elif phase is None:
            continue
        elif event.sequence_nr >= 0:
            # Of the operations with a number, the last one makes the node.
            part_of_node[event.sequence_nr] = part
        own = event.self_device_time_total if on_device else event.self_cpu_time_total
        cells[phase, part] += own
        operations[part, event.name.removeprefix("autograd::engine::evaluate_function: ")] += own
    return Spent(cells, operations)


def _forward_place(names: set[str]) -> tuple[str | None, str]:
    """The phase, if any, and the part of an operation with ancestors of these names."""
    phase = next((p for p in PHASES if p in names), None)
    if phase in ("loss", "optimiser"):
        return phase, phase
    if "warp" in names:
        return phase, "warp"
    if any("conv" in name for name in names):
        return phase, "convolutions"
    return phase, "matrix products" if names.intersection(PRODUCTS) else "rest of network"


@contextmanager
def marked(label: str, places: list[tuple[Any, str]]) -> Iterator[None]:
    """Within, calls of each ``(object, attribute)`` are ranges of that name to a profiler."""
    with ExitStack() as undo:
        for owner, name in places:
            undo.enter_context(patch.object(owner, name, _ranged(label, getattr(owner, name))))
        yield


def _ranged(label: str, function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def ranged(*args: Any, **kwargs: Any) -> Any:
        with record_function(label):
            return function(*args, **kwargs)

    return ranged
