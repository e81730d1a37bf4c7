"""Whether an exported method is the one that PyTorch runs: both roll over the same frames, each with its own state."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
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

OTHER_SIZES = (2, 3), (5, 7), (15, 15)  # times what a size has to be a multiple of


@dataclass(frozen=True)
class Difference:
    """Between the images of a runtime and PyTorch's, in the display's range [0, 1]: the largest, its frame, and the mean."""

    largest: float
    frame: int
    mean: float


@torch.inference_mode()
def compare(model: Upsampler, runners: Mapping[str, Runner], frames: Iterable[Frame]) -> dict[str, Difference]:
    """The difference of each runner from ``model`` in evaluation mode, over a rollout from the first frame."""
    model = model.cpu().eval()
    state: Any = None
    apart: dict[str, list[NDArray[np.float32]]] = {name: [] for name in runners}
    for runner in runners.values():
        runner.reset()
    for frame in frames:
        output, state = model(frame, state)
        image = model.present(output, frame).numpy()
        buffers = arrays(frame)
        for name, runner in runners.items():
            apart[name].append(np.abs(runner(buffers) - image))
    return {name: _difference(maps) for name, maps in apart.items()}


def _difference(maps: Sequence[NDArray[np.float32]]) -> Difference:
    largest = [float(m.max()) for m in maps]
    # A value that is not finite is as far off as can be.
    largest = [value if np.isfinite(value) else float("inf") for value in largest]
    worst = int(np.argmax(largest))
    return Difference(largest[worst], worst, float(np.mean([m.mean() for m in maps])))


def arrays(frame: Frame) -> dict[str, NDArray[np.float32]]:
    """A frame's buffers as a runner takes them."""
    held = {f.name: getattr(frame, f.name) for f in fields(frame)}
    return {name: values.numpy() for name, values in held.items() if values is not None}


def random_frames(model: Upsampler, size: tuple[int, int], count: int, jitters: Tensor | None) -> Iterator[Frame]:
    """Frames of random buffers, ``size`` low-resolution ``(width, height)``, with these jitters ``(N, 2)`` in turn, if given."""
    for t in range(count):
        frame = random_frame(model, *size, "cpu", seed=t)
        given = {f.name: getattr(frame, f.name) for f in fields(frame)}
        if jitters is not None and frame.jitter is not None:
            given["jitter"] = jitters[t % len(jitters)][None]
        yield Frame(**given)


def at_other_sizes(
    model: Upsampler, runners: Mapping[str, Runner], multiple: int, jitters: Tensor | None
) -> dict[tuple[int, int], Difference]:
    """The larger difference of the runners over a few frames at each of several sizes, by low-resolution ``(width, height)``.

    A graph is traced at one size; that it holds for all is checked by `torch.export` as far as that understands a method's
    branches, and here.
    """
    found = {}
    for across, down in OTHER_SIZES:
        size = (across * multiple, down * multiple)
        apart = compare(model, runners, random_frames(model, size, 3, jitters))
        found[size] = max(apart.values(), key=lambda d: d.largest)
    return found


def recorded_frames(
    path: Path, requires: frozenset[str], size: tuple[int, int] | None, multiple: int, count: int
) -> Iterator[Frame]:
    """Frames of a data set file's first clip, over and over; the jump back is a cut that nobody announces.

    Args:
        size: the low-resolution ``(width, height)`` that is cut out from the corner; None for all of it, down to a multiple
            of ``multiple``.

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
