"""Determinism: the same clip repeated, on another number of threads, and in a batch."""

import copy
from collections.abc import Iterator

import torch
from torch import Tensor

from supersampling.models.base import Upsampler
from supersampling.stress.cell import Cell, fit_drift
from supersampling.stress.clip import Clip, make_clip
from supersampling.stress.precision import FLOAT32
from supersampling.stress.trial import Distance, roll, split_frames

FRAMES, BATCH, THREADS = 6, 3, (1, 2)


def outputs(model: Upsampler, clip: Clip, device: str) -> list[Tensor]:
    """Return the outputs of a clip in float32."""
    return [output for output, _ in roll(model, split_frames(clip), torch.float32, device)]


def _distance(first: list[Tensor], second: list[Tensor]) -> Distance:
    distance = Distance()
    for output, reference in zip(first, second):
        distance.add(output, reference.double())
    return distance


def comparisons(model: Upsampler, size: tuple[int, int], device: str) -> Iterator[tuple[str, str, float, Distance]]:
    """Yield the name, meaning, tolerance and distance of each comparison."""
    clip = make_clip(model.requires, FRAMES, *size, model.scale, batch=BATCH)
    batch = outputs(model, clip, device)
    repeated = _distance(outputs(model, clip, device), batch)
    yield "repeated", "The same frames twice: bit-identical.", 0.0, repeated
    single = outputs(model, {name: values[:1] for name, values in clip.items()}, device)
    meaning = f"The first item of a batch of {BATCH} against the same clip in a batch of its own."
    yield "batch", meaning, FLOAT32.largest, _distance([output[:1] for output in batch], single)
    threads = torch.get_num_threads()
    try:
        torch.set_num_threads(THREADS[0])
        single_threaded = outputs(model, clip, device)
        torch.set_num_threads(THREADS[1])
        two_threaded = outputs(model, clip, device)
    finally:
        torch.set_num_threads(threads)
    yield "threads", "One thread against two.", FLOAT32.largest, _distance(two_threaded, single_threaded)


def determinism_cells(name: str, model: Upsampler, size: tuple[int, int], device: str) -> Iterator[Cell]:
    """Yield one cell per comparison."""
    model = copy.deepcopy(model).eval()
    for comparison, meaning, tolerance, distance in comparisons(model, size, device):
        good = distance.finite and distance.largest <= tolerance
        yield Cell(
            model=name,
            extreme=f"determinism/{comparison}",
            precision="float32",
            size=f"{size[0]}x{size[1]}",
            scale=model.scale,
            frames=FRAMES,
            finite=distance.finite,
            largest=distance.largest,
            mean=distance.mean,
            drift=fit_drift(distance.means),
            tolerance=f"{tolerance:g}",
            verdict="holds" if good else "fails",
            reason="" if good else f"{distance.largest:.2g} apart",
            says=meaning,
        )
