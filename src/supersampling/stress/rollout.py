"""Long roll-outs: errors that accumulate over thousands of frames."""

import copy
from collections.abc import Iterator, Sequence
from typing import Any

import torch
from tqdm import tqdm

from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, fit_drift, judge
from supersampling.stress.clip import CYCLE, make_frame, make_inputs
from supersampling.stress.precision import Precision
from supersampling.stress.trial import Distance


@torch.no_grad()
def measure_distances(
    model: Upsampler,
    precisions: Sequence[Precision],
    size: tuple[int, int],
    frames: int,
    moving: bool,
    device: str,
    label: str,
) -> list[Distance]:
    """Return the distance of each precision from float64, all of them rolled out side by side."""
    cycle = [make_inputs(model.requires, t, *size, model.scale, moving=moving) for t in range(CYCLE)]
    exact = copy.deepcopy(model).double()
    state: Any = None
    states: list[Any] = [None] * len(precisions)
    distances = [Distance() for _ in precisions]
    for t in tqdm(range(frames), desc=label, unit="frame", disable=None, leave=False, mininterval=1.0):
        inputs = cycle[t % CYCLE]
        reference, state = exact(make_frame(inputs, torch.float64, device), state)
        frame = make_frame(inputs, torch.float32, device)
        for k, precision in enumerate(precisions):
            with precision.context(device):
                output, states[k] = model(frame, states[k])
            distances[k].add(output, reference)
            distances[k].finite &= bool(model.present(output.float(), frame).isfinite().all())
    return distances


def rollout_cells(
    name: str,
    model: Upsampler,
    precisions: Sequence[Precision],
    size: tuple[int, int],
    lengths: Sequence[int],
    device: str,
) -> Iterator[Cell]:
    """Yield one cell per length, static and moving, and precision.

    ``value`` is the mean error of the last tenth of the frames.
    """
    model = copy.deepcopy(model).eval()
    for frames in lengths:
        for moving in (False, True):
            extreme = f"rollout/{frames} frames, {'moving' if moving else 'static'}"
            label = f"{name}: {extreme}"
            distances = measure_distances(model, precisions, size, frames, moving, device, label)
            for precision, distance in zip(precisions, distances):
                verdict, reason = judge(distance.finite, distance.largest, distance.mean, "", precision.limits)
                last = distance.means[-max(1, frames // 10) :]
                yield Cell(
                    model=name,
                    extreme=extreme,
                    precision=precision.name,
                    size=f"{size[0]}x{size[1]}",
                    scale=model.scale,
                    frames=frames,
                    finite=distance.finite,
                    largest=distance.largest,
                    mean=distance.mean,
                    drift=fit_drift(distance.means),
                    value=sum(last) / len(last),
                    tolerance=precision.tolerance,
                    verdict=verdict,
                    reason=reason,
                    says="A camera that moves in a circle without end." if moving else "Only jitter, without end.",
                )
