"""Recovery: the number of frames until a model is clean again after a frame, or a state, that is not finite."""

import copy
import math
from collections.abc import Iterator
from typing import Any

import torch
from torch import Tensor
from torch.utils._pytree import tree_map_only

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, Verdict
from supersampling.stress.clip import make_frame, make_inputs
from supersampling.stress.precision import FLOAT32
from supersampling.stress.trial import Distance

BEFORE = 6  # frames before the bad one, so that the longest window is full


def faults(model: Upsampler) -> list[str]:
    """Return the names of the faults: NaN in each buffer that the model reads, infinite light, and a bad state."""
    buffers = sorted(model.requires)
    light = [name for name in ("color", "radiance") if name in buffers]
    return [f"{name} NaN" for name in buffers] + [f"{name} Inf" for name in light] + ["state NaN", "state Inf"]


def inject_fault(frame: Frame, state: Any, fault: str) -> tuple[Frame, Any]:
    """Return the frame and the state before it, with the fault."""
    name, _, kind = fault.partition(" ")
    value = math.nan if kind == "NaN" else math.inf
    if name == "state":
        return frame, tree_map_only(Tensor, lambda tensor: torch.full_like(tensor, value), state)
    return Frame(**{**frame.__dict__, name: torch.full_like(getattr(frame, name), value)}), state


@torch.no_grad()
def measure_recovery(
    model: Upsampler, fault: str, size: tuple[int, int], horizon: int, device: str
) -> tuple[list[float], list[bool]]:
    """Return, for the bad frame and the ``horizon`` frames after it, the largest distance and the finiteness.

    The distance is from the undisturbed roll-out; a frame is finite if its output and its displayed image are.
    """
    state: Any = None
    disturbed_state: Any = None
    distances, finite = [], []
    for t in range(BEFORE + horizon + 1):
        frame = make_frame(make_inputs(model.requires, t, *size, model.scale), torch.float32, device)
        previous = state
        output, state = model(frame, state)
        if t < BEFORE:
            continue
        if t == BEFORE:
            disturbed_frame, disturbed_state = inject_fault(frame, previous, fault)
        else:
            disturbed_frame = frame
        disturbed, disturbed_state = model(disturbed_frame, disturbed_state)
        distance = Distance()
        distance.add(disturbed, output.double())
        distances.append(distance.largest)
        finite.append(distance.finite and bool(model.present(disturbed, disturbed_frame).isfinite().all()))
    return distances, finite


def count_until(clean: list[bool]) -> float:
    """Return the first index from which all are true; NaN if the last is not."""
    if not clean[-1]:
        return math.nan
    return float(len(clean) - next((k for k, good in enumerate(reversed(clean)) if not good), len(clean)))


def decreases(distances: list[float]) -> bool:
    """Return whether the mean distance of the last quarter of the frames is below that of the quarter before.

    A history is replaced as fast as its gates say, and random gates may keep some of it for long.
    """
    quarter = max(1, len(distances) // 4)
    return sum(distances[-quarter:]) < sum(distances[-2 * quarter : -quarter])


def _judge(distances: list[float], finite: list[bool], clean: float) -> tuple[Verdict, str]:
    horizon = len(distances) - 1
    bad = count_until(finite)
    if math.isnan(bad):
        return "fails", f"not finite after {horizon} frames"
    if not math.isnan(clean):
        return "holds", f"not finite for {bad:.0f} frames" if bad > 0 else ""
    distance = f"{distances[-1]:.2g} away after {horizon} frames"
    if decreases(distances):
        return "holds", f"{distance}, and nearing"
    return "fails", f"{distance}, no longer nearing"


def recovery_cells(name: str, model: Upsampler, size: tuple[int, int], horizon: int, device: str) -> Iterator[Cell]:
    """Yield one cell per fault; ``value`` is the number of frames that are not clean, including the bad one."""
    model = copy.deepcopy(model).eval()
    for fault in faults(model):
        distances, finite = measure_recovery(model, fault, size, horizon, device)
        clean = count_until([f and d <= FLOAT32.largest for d, f in zip(distances, finite)])
        verdict, reason = _judge(distances, finite, clean)
        yield Cell(
            model=name,
            extreme=f"recovery/{fault}",
            precision="float32",
            size=f"{size[0]}x{size[1]}",
            scale=model.scale,
            frames=horizon + 1,
            finite=all(finite),
            largest=max(distances),
            value=clean,
            tolerance=f"clean or nearing, {horizon} frames",
            verdict=verdict,
            reason=reason,
            says="Frames until finite and within float32's tolerance of the undisturbed roll-out.",
        )
