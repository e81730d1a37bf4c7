"""Comparison of an exported method with PyTorch: both roll over the same frames, each with a state of its own."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from supersampling.data.dataset_file import DatasetFile
from supersampling.deploy.runner import Runner
from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame
from supersampling.models.base import Upsampler
from supersampling.models.count import random_frame

CHECKED_SIZES = (2, 3), (5, 7), (15, 15)  # multiples of the number that a size has to be a multiple of


@dataclass(frozen=True)
class Difference:
    """Difference of a runtime's images from PyTorch's, in the display's range [0, 1].

    ``frame`` is the frame of the ``largest`` difference; ``mean`` is over all frames.
    """

    largest: float
    frame: int
    mean: float


@torch.inference_mode()
def compare(model: Upsampler, runners: Mapping[str, Runner], frames: Iterable[Frame]) -> dict[str, Difference]:
    """Return the difference of each runner from ``model`` in evaluation mode, over a roll-out from the first frame."""
    model = model.cpu().eval()
    state: Any = None
    differences: dict[str, list[NDArray[np.float32]]] = {name: [] for name in runners}
    for runner in runners.values():
        runner.reset()
    for frame in frames:
        output, state = model(frame, state)
        image = model.present(output, frame).numpy()
        inputs = arrays(frame)
        for name, runner in runners.items():
            differences[name].append(np.abs(runner(inputs) - image))
    return {name: _summarise(maps) for name, maps in differences.items()}


def _summarise(maps: Sequence[NDArray[np.float32]]) -> Difference:
    largest = [float(m.max()) for m in maps]
    # A value that is not finite counts as an infinite difference.
    largest = [value if np.isfinite(value) else float("inf") for value in largest]
    worst = int(np.argmax(largest))
    return Difference(largest[worst], worst, float(np.mean([m.mean() for m in maps])))


def buffers(frame: Frame) -> dict[str, Tensor]:
    """Return the buffers that a frame has, by name."""
    values = {f.name: getattr(frame, f.name) for f in fields(frame)}
    return {name: value for name, value in values.items() if value is not None}


def arrays(frame: Frame) -> dict[str, NDArray[np.float32]]:
    """Return the buffers that a frame has as arrays by name, the inputs of a runner."""
    return {name: values.numpy() for name, values in buffers(frame).items()}


def random_frames(model: Upsampler, size: tuple[int, int], count: int, jitters: Tensor | None) -> Iterator[Frame]:
    """Yield frames of random buffers; ``size`` is the low-resolution ``(width, height)``.

    ``jitters`` ``(N, 2)`` are taken in turn; None keeps random ones.
    """
    for t in range(count):
        frame = random_frame(model, *size, "cpu", seed=t)
        if jitters is not None and frame.jitter is not None:
            frame = replace(frame, jitter=jitters[t % len(jitters)][None])
        yield frame


def compare_other_sizes(
    model: Upsampler, runners: Mapping[str, Runner], multiple: int, jitters: Tensor | None
) -> dict[tuple[int, int], Difference]:
    """Return the largest difference of the runners over three frames at each of several sizes.

    Keys are low-resolution ``(width, height)``. A graph is traced at one size. `torch.export` checks that it is valid
    for all sizes as far as it understands a method's branches; this function checks the rest.
    """
    differences = {}
    for columns, rows in CHECKED_SIZES:
        size = (columns * multiple, rows * multiple)
        by_runner = compare(model, runners, random_frames(model, size, 3, jitters))
        differences[size] = max(by_runner.values(), key=lambda d: d.largest)
    return differences


def recorded_frames(
    path: Path, requires: frozenset[str], size: tuple[int, int] | None, multiple: int, count: int
) -> Iterator[Frame]:
    """Yield ``count`` frames of a data set file's first clip, repeated; each jump back is a cut without a reset.

    Args:
        size: low-resolution ``(width, height)`` of the window that is cut out at the top-left corner; None for the
            whole frame, rounded down to a multiple of ``multiple``.

    Raises:
        UserError: the clip is smaller.
    """
    store = DatasetFile(path)
    try:
        scale = store.spec.scale
        width, height = (n // scale for n in store.spec.target_size)
        w, h = size or (width // multiple * multiple, height // multiple * multiple)
        if w > width or h > height:
            raise UserError(
                f"{path} has frames of {width}x{height} low-resolution pixels, too few for size=[{w},{h}]: use "
                "frames=random, or a data set of larger windows."
            )
        windows = {"low": (0, 0, w, h), "high": (0, 0, w * scale, h * scale), "frame": None}
        first = store.spec.frames - store.spec.targets
        for t in range(count):
            k = first + t % store.spec.targets
            read = {n: store.read(n, 0, slice(k, k + 1), windows[BUFFERS[n].resolution]) for n in requires}
            yield Frame(**{name: torch.from_numpy(values) for name, values in read.items()})
    finally:
        store.close()
