"""Breakdown of a training step's time: the self time of every operation by phase and part, from a profile."""

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

# Otherwise the profiler prints a line for each start and stop.
os.environ.setdefault("KINETO_LOG_LEVEL", "9")

PROFILED = 5
PHASES = ("forward", "loss", "backward", "optimiser")
PARTS = ("convolutions", "matrix products", "warp", "rest of network", "loss", "optimiser")
PRODUCTS = ("aten::linear", "aten::matmul", "aten::mm", "aten::addmm", "aten::bmm", "aten::baddbmm")
UPSAMPLING = (resample.jitter_aligned_upsample, resample.zero_upsample, resample.upsample_motion)
WARPS = (chain.chain, warp.warp, warp.outside, warp.sampling_grid, *UPSAMPLING)
WARPING_STAGES = {m.__name__ for m in (dilate, motion_grid, pad, reproject, upsample, warp_at)}


@dataclass(frozen=True)
class Breakdown:
    """Microseconds of a step by ``(phase, part)``, and by ``(part, operation)``."""

    cells: Counter[tuple[str, str]]
    operations: Counter[tuple[str, str]]

    def share(self, phase: str | None = None, part: str | None = None) -> float:
        selected = (v for (a, b), v in self.cells.items() if phase in (None, a) and part in (None, b))
        return sum(selected) / self.cells.total()

    def largest(self, part: str) -> str:
        """Return the five most expensive operations of a part; backward operations are separate."""
        costs = Counter({op: v for (p, op), v in self.operations.items() if p == part})
        return ", ".join(f"{op} {100 * v / self.cells.total():.0f}%" for op, v in costs.most_common(5))


def warping_attributes(model: torch.nn.Module) -> list[tuple[Any, str]]:
    """Return the attributes that warp or upsample: stages of a model, and functions in all modules that import them."""
    stages = [(m, "forward") for m in model.modules() if type(m).__module__ in WARPING_STAGES]
    loaded = [m for name, m in sys.modules.items() if name.startswith("supersampling.")]
    functions = [(m, name) for m in loaded for name, value in vars(m).items() if any(value is w for w in WARPS)]
    return [*stages, *functions]


def measure_breakdown(case: Case) -> Breakdown:
    """Return medians over `PROFILED` steps."""
    with profiler_ranges("warp", warping_attributes(case.model)):
        steps = [_profile_step(case) for _ in range(PROFILED + 1)][1:]
    cells, operations = ([getattr(step, name) for step in steps] for name in ("cells", "operations"))
    return Breakdown(_medians(cells), _medians(operations))


def _medians(steps: list[Counter[tuple[str, str]]]) -> Counter[tuple[str, str]]:
    return Counter({key: statistics.median(step[key] for step in steps) for key in set().union(*steps)})


def _profile_step(case: Case) -> Breakdown:
    """Return the self time of every operation by phase and part; a gradient belongs to the part of its operation."""
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
        phase, part = _classify({e.name for e in lineage})
        if nodes:
            # On an accelerator, the backward pass has its own thread, outside the marked range.
            phase, part = "backward", part_of_node.get(nodes[-1].sequence_nr, part)
        elif phase is None:
            continue
        elif event.sequence_nr >= 0:
            # The last operation with a sequence number creates the node.
            part_of_node[event.sequence_nr] = part
        self_time = event.self_device_time_total if on_device else event.self_cpu_time_total
        cells[phase, part] += self_time
        operations[part, event.name.removeprefix("autograd::engine::evaluate_function: ")] += self_time
    return Breakdown(cells, operations)


def _classify(names: set[str]) -> tuple[str | None, str]:
    """Return the phase, if any, and the part of an operation whose ancestors have these names."""
    phase = next((p for p in PHASES if p in names), None)
    if phase in ("loss", "optimiser"):
        return phase, phase
    if "warp" in names:
        return phase, "warp"
    if any("conv" in name for name in names):
        return phase, "convolutions"
    return phase, "matrix products" if names.intersection(PRODUCTS) else "rest of network"


@contextmanager
def profiler_ranges(label: str, attributes: list[tuple[Any, str]]) -> Iterator[None]:
    """Label the calls of each ``(object, attribute)`` as a range for the profiler."""
    with ExitStack() as patches:
        for owner, name in attributes:
            patches.enter_context(patch.object(owner, name, _label_calls(label, getattr(owner, name))))
        yield


def _label_calls(label: str, function: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(function)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        with record_function(label):
            return function(*args, **kwargs)

    return wrapper
