"""A model at an extreme, compared with itself in float64 frame by frame."""

import copy
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import torch
from torch import Tensor

from supersampling.losses.temporal import SpatioTemporal
from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, drift_of, judge
from supersampling.stress.clip import Clip, clip_of, frame_of
from supersampling.stress.extreme import Extreme
from supersampling.stress.precision import Precision
from supersampling.training.module import unroll

THETA = 0.5
LARGE = 2**14  # target pixels above which gradients are not made: they keep all that the roll-out computed
COUNTED = 2  # frames that the loss of a gradient sees


@dataclass
class Distance:
    """What a roll-out is away from another one; see `Cell` for units."""

    finite: bool = True
    largest: float = 0.0
    means: list[float] = field(default_factory=list)

    def add(self, output: Tensor, reference: Tensor) -> None:
        if not bool(output.isfinite().all()):
            self.finite = False
            self.means.append(math.inf)
            self.largest = math.inf
            return
        known = reference.isfinite()
        size = max(1.0, float(reference[known].abs().max())) if bool(known.any()) else 1.0
        apart = (output.double() - reference).abs() / size
        apart = torch.where(known, apart, 0.0)
        self.largest = max(self.largest, float(apart.max()))
        self.means.append(float(apart.mean()))

    @property
    def mean(self) -> float:
        return max(self.means, default=math.nan)


def frames_of(clip: Clip) -> Iterator[Clip]:
    length = max(values.shape[1] for values in clip.values())
    for t in range(length):
        yield {name: values[:, t] for name, values in clip.items()}


@torch.no_grad()
def roll(
    model: Upsampler,
    frames: Iterable[Clip],
    dtype: torch.dtype,
    device: str,
    precision: Precision | None = None,
) -> Iterator[tuple[Tensor, bool]]:
    """Outputs in the method's own domain, and whether what is displayed of each is finite."""
    state: Any = None
    for inputs in frames:
        frame = frame_of(inputs, dtype, device)
        if precision is None:
            output, state = model(frame, state)
        else:
            with precision.context(device):
                output, state = model(frame, state)
        shown = model.present(output.to(dtype), frame)
        yield output, bool(shown.isfinite().all())


def distance(model: Upsampler, clip: Clip, references: Sequence[Tensor], precision: Precision, device: str) -> Distance:
    found = Distance()
    rolled = roll(model, frames_of(clip), torch.float32, device, precision)
    for (output, shown), reference in zip(rolled, references):
        found.add(output, reference)
        found.finite &= shown
    return found


def reference_of(model: Upsampler, clip: Clip, device: str) -> list[Tensor]:
    """The same model's outputs in float64, of the same float32 buffers."""
    exact = copy.deepcopy(model).double()
    return [output for output, _ in roll(exact, frames_of(clip), torch.float64, device)]


def gradient(model: Upsampler, clip: Clip, precision: Precision, device: str, theta: float = THETA) -> str:
    """Whether the gradients of L1 and of the spatio-temporal loss are finite, in training mode."""
    if not any(p.requires_grad for p in model.parameters()):
        return ""
    model = copy.deepcopy(model).train()
    buffers = {name: values.float().to(device) for name, values in clip.items()}
    kept = min(COUNTED + 1, max(v.shape[1] for v in buffers.values()))
    with precision.context(device):
        outputs = unroll(model, buffers, kept)
        last = {name: values[:, -kept:] for name, values in buffers.items()}
        targets = model.reference(last)
        value = (outputs - targets).abs().mean()
        if kept > 1 and "motion" in last:
            value = value + SpatioTemporal(theta)(outputs, targets, last)
    value.backward()
    grads = [p.grad for p in model.parameters() if p.grad is not None]
    return "finite" if all(bool(g.isfinite().all()) for g in grads) else "not finite"


def cells_of(
    name: str,
    model: Upsampler,
    extreme: Extreme,
    precisions: Sequence[Precision],
    size: tuple[int, int],
    device: str,
    skip: str = "",
) -> Iterator[Cell]:
    """A cell for each precision; ``model`` is of the extreme's scale. ``skip`` is why nothing is tried.

    Nothing is given where the extreme does not concern the model.
    """
    if not extreme.concerns(model):
        return
    model = copy.deepcopy(model).eval()
    if extreme.adjust is not None and not extreme.adjust(model):
        return
    width, height = extreme.low(size, model.scale)
    bare = Cell(name, extreme.name, "", f"{width}x{height}", model.scale, extreme.frames, says=extreme.says)
    if not skip:
        wanted = model.requires | model.compares | {"motion"}
        clip = extreme.change(clip_of(wanted, extreme.frames, width, height, model.scale))
        references = reference_of(model, clip, device)
    for precision in precisions:
        bare = replace(bare, precision=precision.name, tolerance=precision.tolerance)
        if skip:
            yield replace(bare, why=skip)
            continue
        found = distance(model, clip, references, precision, device)
        large = width * height * model.scale**2 > LARGE
        grads = "" if large else gradient(model, clip, precision, device)
        verdict, why = judge(found.finite, found.largest, found.mean, grads, precision.limits)
        yield replace(
            bare,
            finite=found.finite,
            largest=found.largest,
            mean=found.mean,
            drift=drift_of(found.means),
            gradient=grads,
            verdict=verdict,
            why=why,
        )
