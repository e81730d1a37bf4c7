"""Whether the same is the same: repeated, on other numbers of threads, and in a batch."""

import copy
from collections.abc import Iterator

import torch
from torch import Tensor

from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, drift_of
from supersampling.stress.clip import Clip, clip_of
from supersampling.stress.precision import PRECISIONS
from supersampling.stress.trial import Distance, frames_of, roll

FRAMES, BATCH, THREADS = 6, 3, (1, 2)
FLOAT32 = PRECISIONS["float32"]


def outputs(model: Upsampler, clip: Clip, device: str) -> list[Tensor]:
    return [output for output, _ in roll(model, frames_of(clip), torch.float32, device)]


def _apart(first: list[Tensor], second: list[Tensor]) -> Distance:
    found = Distance()
    for a, b in zip(first, second):
        found.add(a, b.double())
    return found


def compared(model: Upsampler, size: tuple[int, int], device: str) -> Iterator[tuple[str, str, float, Distance]]:
    """Name, sentence, tolerance, distance."""
    clip = clip_of(model.requires, FRAMES, *size, model.scale, batch=BATCH)
    once = outputs(model, clip, device)
    yield (
        "repeated",
        "The same frames twice: equal to the bit.",
        0.0,
        _apart(outputs(model, clip, device), once),
    )
    single = {name: values[:1] for name, values in clip.items()}
    alone = outputs(model, single, device)
    said = f"The first of a batch of {BATCH} against the same clip alone."
    yield "batch", said, FLOAT32.largest, _apart([o[:1] for o in once], alone)
    before = torch.get_num_threads()
    try:
        torch.set_num_threads(THREADS[0])
        one = outputs(model, clip, device)
        torch.set_num_threads(THREADS[1])
        two = outputs(model, clip, device)
    finally:
        torch.set_num_threads(before)
    yield "threads", "One thread against two.", FLOAT32.largest, _apart(two, one)


def determinism_cells(name: str, model: Upsampler, size: tuple[int, int], device: str) -> Iterator[Cell]:
    model = copy.deepcopy(model).eval()
    for what, says, tolerance, found in compared(model, size, device):
        good = found.finite and found.largest <= tolerance
        yield Cell(
            name,
            f"determinism/{what}",
            "float32",
            f"{size[0]}x{size[1]}",
            model.scale,
            FRAMES,
            finite=found.finite,
            largest=found.largest,
            mean=found.mean,
            drift=drift_of(found.means),
            tolerance=f"{tolerance:g}",
            verdict="holds" if good else "fails",
            why="" if good else f"{found.largest:.2g} apart",
            says=says,
        )
