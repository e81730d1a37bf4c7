"""After how many frames a model is clean again: of a frame, or a state, that is not finite."""

import copy
import math
from collections.abc import Iterator
from typing import Any

import torch
from torch import Tensor
from torch.utils._pytree import tree_map_only

from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell
from supersampling.stress.clip import frame_of, inputs_at
from supersampling.stress.precision import PRECISIONS
from supersampling.stress.trial import Distance

BEFORE = 6  # frames before the bad one: the longest window is full
FLOAT32 = PRECISIONS["float32"]


def faults(model: Upsampler) -> list[str]:
    """NaN in each buffer that is read, in turn, then what a renderer also gives, then the state."""
    read = sorted(model.requires)
    light = [name for name in ("color", "radiance") if name in read]
    return [f"{name} NaN" for name in read] + [f"{name} Inf" for name in light] + ["state NaN", "state Inf"]


def spoiled(frame: Frame, state: Any, fault: str) -> tuple[Frame, Any]:
    """The frame and the state before it with the fault."""
    name, _, kind = fault.partition(" ")
    value = math.nan if kind == "NaN" else math.inf
    if name == "state":
        return frame, tree_map_only(Tensor, lambda t: torch.full_like(t, value), state)
    return Frame(**{**frame.__dict__, name: torch.full_like(getattr(frame, name), value)}), state


@torch.no_grad()
def recovery(
    model: Upsampler, fault: str, size: tuple[int, int], horizon: int, device: str
) -> tuple[list[float], list[bool]]:
    """Of the bad frame and the ``horizon`` frames after it: the largest distance from the undisturbed roll-out, and whether
    all is finite."""
    state: Any = None
    spoilt: Any = None
    apart, finite = [], []
    for t in range(BEFORE + horizon + 1):
        frame = frame_of(inputs_at(model.requires, t, *size, model.scale), torch.float32, device)
        before = state
        output, state = model(frame, state)
        if t < BEFORE:
            continue
        bad, spoilt = spoiled(frame, before, fault) if t == BEFORE else (frame, spoilt)
        found, spoilt = model(bad, spoilt)
        distance = Distance()
        distance.add(found, output.double())
        apart.append(distance.largest)
        finite.append(distance.finite and bool(model.present(found, bad).isfinite().all()))
    return apart, finite


def frames_until(clean: list[bool]) -> float:
    """The first index from which all are true; NaN if the last is not."""
    if not clean[-1]:
        return math.nan
    return float(len(clean) - next((k for k, good in enumerate(reversed(clean)) if not good), len(clean)))


def nears(apart: list[float]) -> bool:
    """Whether the mean distance of the last quarter of the frames is below that of the quarter before: how fast a history is
    replaced, its gates say, and random ones may hold some of it for long."""
    quarter = max(1, len(apart) // 4)
    return sum(apart[-quarter:]) < sum(apart[-2 * quarter : -quarter])


def recovery_cells(name: str, model: Upsampler, size: tuple[int, int], horizon: int, device: str) -> Iterator[Cell]:
    """A cell for each fault; ``value`` is the number of frames that are not as they should be, the bad one among them."""
    model = copy.deepcopy(model).eval()
    for fault in faults(model):
        apart, finite = recovery(model, fault, size, horizon, device)
        clean = frames_until([f and a <= FLOAT32.largest for a, f in zip(apart, finite)])
        lasting = frames_until(finite)
        why = f"not finite for {lasting:.0f} frames" if lasting > 0 else ""
        if math.isnan(lasting):
            why = f"not finite after {horizon} frames"
        elif math.isnan(clean):
            why = (
                f"{apart[-1]:.2g} away after {horizon} frames, {'and nearing' if nears(apart) else 'no longer nearing'}"
            )
        yield Cell(
            name,
            f"recovery/{fault}",
            "float32",
            f"{size[0]}x{size[1]}",
            model.scale,
            horizon + 1,
            finite=all(finite),
            largest=max(apart),
            value=clean,
            tolerance=f"clean or nearing, {horizon} frames",
            verdict="holds" if not math.isnan(clean) or (not math.isnan(lasting) and nears(apart)) else "fails",
            why=why,
            says="Frames until finite and within float32's tolerance of the undisturbed roll-out.",
        )
