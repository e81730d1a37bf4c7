"""Long roll-outs: what adds up over thousands of frames."""

import copy
from collections.abc import Iterator, Sequence
from typing import Any

import torch
from tqdm import tqdm

from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, drift_of, judge
from supersampling.stress.clip import CYCLE, frame_of, inputs_at
from supersampling.stress.precision import Precision
from supersampling.stress.trial import Distance


@torch.no_grad()
def distances(
    model: Upsampler,
    precisions: Sequence[Precision],
    size: tuple[int, int],
    frames: int,
    moving: bool,
    device: str,
    label: str,
) -> list[Distance]:
    """Of each precision from float64, both running side by side."""
    cycle = [inputs_at(model.requires, t, *size, model.scale, moving=moving) for t in range(CYCLE)]
    exact = copy.deepcopy(model).double()
    state: Any = None
    states: list[Any] = [None] * len(precisions)
    found = [Distance() for _ in precisions]
    for t in tqdm(range(frames), desc=label, unit="frame", disable=None, leave=False, mininterval=1.0):
        inputs = cycle[t % CYCLE]
        reference, state = exact(frame_of(inputs, torch.float64, device), state)
        frame = frame_of(inputs, torch.float32, device)
        for k, precision in enumerate(precisions):
            with precision.context(device):
                output, states[k] = model(frame, states[k])
            found[k].add(output, reference)
            found[k].finite &= bool(model.present(output.float(), frame).isfinite().all())
    return found


def rollout_cells(
    name: str,
    model: Upsampler,
    precisions: Sequence[Precision],
    size: tuple[int, int],
    lengths: Sequence[int],
    device: str,
) -> Iterator[Cell]:
    """A cell for each length, standing and moving, and precision. ``value`` is the mean error of the last tenth of the frames."""
    model = copy.deepcopy(model).eval()
    for frames in lengths:
        for moving in (False, True):
            what = f"rollout/{frames} frames, {'moving' if moving else 'static'}"
            for precision, found in zip(
                precisions, distances(model, precisions, size, frames, moving, device, f"{name}: {what}")
            ):
                verdict, why = judge(found.finite, found.largest, found.mean, "", precision.limits)
                last = found.means[-max(1, frames // 10) :]
                yield Cell(
                    name,
                    what,
                    precision.name,
                    f"{size[0]}x{size[1]}",
                    model.scale,
                    frames,
                    finite=found.finite,
                    largest=found.largest,
                    mean=found.mean,
                    drift=drift_of(found.means),
                    value=sum(last) / len(last),
                    tolerance=precision.tolerance,
                    verdict=verdict,
                    why=why,
                    says="A camera that circles for ever." if moving else "Jitter alone, for ever.",
                )
