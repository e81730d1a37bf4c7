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
from supersampling.stress.cell import Cell, fit_drift, judge
from supersampling.stress.clip import Clip, make_clip, make_frame
from supersampling.stress.extreme import Extreme
from supersampling.stress.precision import Precision
from supersampling.training.module import unroll

THETA = 0.5
LARGE = 2**14  # target pixels above which gradients are not computed: they keep all tensors of the roll-out
LOSS_FRAMES = 2  # frames that the loss of a gradient reads


@dataclass
class Distance:
    """The distance between two roll-outs: the largest difference and each frame's mean; see `Cell` for units."""

    finite: bool = True
    largest: float = 0.0
    means: list[float] = field(default_factory=list)

    def add(self, output: Tensor, reference: Tensor) -> None:
        """Add a frame. Pixels whose reference is not finite are not compared."""
        if not bool(output.isfinite().all()):
            self.finite = False
            self.means.append(math.inf)
            self.largest = math.inf
            return
        known = reference.isfinite()
        magnitude = max(1.0, float(reference[known].abs().max())) if bool(known.any()) else 1.0
        difference = (output.double() - reference).abs() / magnitude
        difference = torch.where(known, difference, 0.0)
        self.largest = max(self.largest, float(difference.max()))
        self.means.append(float(difference.mean()))

    @property
    def mean(self) -> float:
        """The mean difference of the worst frame."""
        return max(self.means, default=math.nan)


def split_frames(clip: Clip) -> Iterator[Clip]:
    """Yield the buffers of each frame."""
    length = max(values.shape[1] for values in clip.values())
    for t in range(length):
        yield {name: values[:, t] for name, values in clip.items()}


@torch.no_grad()
def roll(
    model: Upsampler, frames: Iterable[Clip], dtype: torch.dtype, device: str, precision: Precision | None = None
) -> Iterator[tuple[Tensor, bool]]:
    """Yield each output in the method's own domain, and whether the displayed image is finite."""
    state: Any = None
    for inputs in frames:
        frame = make_frame(inputs, dtype, device)
        if precision is None:
            output, state = model(frame, state)
        else:
            with precision.context(device):
                output, state = model(frame, state)
        image = model.present(output.to(dtype), frame)
        yield output, bool(image.isfinite().all())


def measure_distance(
    model: Upsampler, clip: Clip, references: Sequence[Tensor], precision: Precision, device: str
) -> Distance:
    """Return the distance of the model's outputs in a precision from the references."""
    distance = Distance()
    outputs = roll(model, split_frames(clip), torch.float32, device, precision)
    for (output, finite), reference in zip(outputs, references):
        distance.add(output, reference)
        distance.finite &= finite
    return distance


def roll_reference(model: Upsampler, clip: Clip, device: str) -> list[Tensor]:
    """Return the outputs of the same model in float64, on the same float32 buffers."""
    exact = copy.deepcopy(model).double()
    return [output for output, _ in roll(exact, split_frames(clip), torch.float64, device)]


def check_gradient(model: Upsampler, clip: Clip, precision: Precision, device: str, theta: float = THETA) -> str:
    """Return whether the gradients of L1 and of the spatio-temporal loss are finite in training mode, as in `Cell`."""
    if not any(p.requires_grad for p in model.parameters()):
        return ""
    model = copy.deepcopy(model).train()
    buffers = {name: values.float().to(device) for name, values in clip.items()}
    count = min(LOSS_FRAMES + 1, max(v.shape[1] for v in buffers.values()))
    with precision.context(device):
        outputs = unroll(model, buffers, count)
        last = {name: values[:, -count:] for name, values in buffers.items()}
        targets = model.reference(last)
        loss = (outputs - targets).abs().mean()
        if count > 1 and "motion" in last:
            loss = loss + SpatioTemporal(theta)(outputs, targets, last)
    loss.backward()
    gradients = [p.grad for p in model.parameters() if p.grad is not None]
    return "finite" if all(bool(g.isfinite().all()) for g in gradients) else "not finite"


def extreme_cells(
    name: str,
    model: Upsampler,
    extreme: Extreme,
    precisions: Sequence[Precision],
    size: tuple[int, int],
    device: str,
    skip: str = "",
) -> Iterator[Cell]:
    """Yield one cell per precision; none if the extreme does not concern the model.

    Args:
        model: of the extreme's scale.
        skip: the reason that nothing is tried; empty to try.
    """
    if not extreme.concerns(model):
        return
    model = copy.deepcopy(model).eval()
    if extreme.adjust is not None and not extreme.adjust(model):
        return
    width, height = extreme.low_size(size, model.scale)
    template = Cell(
        model=name,
        extreme=extreme.name,
        precision="",
        size=f"{width}x{height}",
        scale=model.scale,
        frames=extreme.frames,
        says=extreme.meaning,
    )
    if not skip:
        buffers = model.requires | model.compares | {"motion"}
        clip = extreme.change(make_clip(buffers, extreme.frames, width, height, model.scale))
        references = roll_reference(model, clip, device)
    for precision in precisions:
        cell = replace(template, precision=precision.name, tolerance=precision.tolerance)
        if skip:
            yield replace(cell, reason=skip)
            continue
        distance = measure_distance(model, clip, references, precision, device)
        large = width * height * model.scale**2 > LARGE
        gradient = "" if large else check_gradient(model, clip, precision, device)
        verdict, reason = judge(distance.finite, distance.largest, distance.mean, gradient, precision.limits)
        yield replace(
            cell,
            finite=distance.finite,
            largest=distance.largest,
            mean=distance.mean,
            drift=fit_drift(distance.means),
            gradient=gradient,
            verdict=verdict,
            reason=reason,
        )
