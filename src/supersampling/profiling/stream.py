"""Streaming use: frames one at a time, as a game renders them, and the time of each."""

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from supersampling.deploy.check import buffers
from supersampling.frames import Frame
from supersampling.models.base import Upsampler
from supersampling.models.count import LONGEST, random_frame
from supersampling.profiling.backends import Stream
from supersampling.profiling.ceiling import synchronise

Clock = Callable[[], float]  # seconds
FEWEST, MOST = 4, 64  # number of distinct frames
SETTLING = 2  # frames after the state has reached its full size, in which code runs for the first time
SMOOTH = 8  # motion varies over an eighth of the image: neighbours read neighbours, as in a rendered frame
_CACHES = Path("/sys/devices/system/cpu/cpu0/cache")
USUAL_CACHE = 2**25  # bytes


@dataclass(frozen=True)
class Spread:
    """Median and quartiles of ``count`` values."""

    median: float
    low: float
    high: float
    count: int


def spread(values: Sequence[float]) -> Spread:
    """Return the spread of at least one value."""
    low, median, high = np.quantile(values, (0.25, 0.5, 0.75))
    return Spread(float(median), float(low), float(high), len(values))


def cache_size() -> int:
    """Return the bytes of this processor's largest cache; 32 MiB if the system does not say."""
    units = {"K": 2**10, "M": 2**20, "G": 2**30}
    sizes = [p.read_text().strip() for p in _CACHES.glob("index*/size")]
    return max((int(s[:-1]) * units[s[-1]] for s in sizes if s[-1:] in units), default=USUAL_CACHE)


def distinct_frames(model: Upsampler, width: int, height: int, jitters: Tensor | None, cache: int) -> list[Frame]:
    """Return 4 to 64 random frames that together are larger than ``cache`` bytes, with the jitters in turn.

    Motion is smooth, at most 1 % of the image.

    Args:
        width, height: of the low-resolution input.
        jitters: ``(N, 2)``, or None for random ones.
    """
    first = _frame(model, width, height, jitters, 0)
    frame_bytes = sum(values.nbytes for values in buffers(first).values())
    count = min(max(FEWEST, cache // frame_bytes + 1), MOST)
    return [first, *(_frame(model, width, height, jitters, t) for t in range(1, count))]


def _frame(model: Upsampler, width: int, height: int, jitters: Tensor | None, t: int) -> Frame:
    frame = random_frame(model, width, height, "cpu", seed=t)
    changed = {
        name: F.interpolate(values[..., :SMOOTH, :SMOOTH], values.shape[-2:], mode="bilinear")
        for name, values in buffers(frame).items()
        if "motion" in name
    }
    if jitters is not None and frame.jitter is not None:
        changed["jitter"] = jitters[t % len(jitters)][None]
    return replace(frame, **changed)


class Streaming:
    """A loaded method with frames that it runs on in turn, again and again."""

    def __init__(
        self, stream: Stream, frames: Sequence[Frame], device: torch.device, clock: Clock = time.perf_counter
    ) -> None:
        self.stream = stream
        self._frames = itertools.cycle([stream.prepare(frame) for frame in frames])
        self._device, self._clock = device, clock

    def step(self) -> Any:
        """Return the next frame's result after the device has finished."""
        result = self.stream.step(next(self._frames))
        synchronise(self._device)
        return result

    def warm_up(self) -> None:
        """Run until the state has its full size, and `SETTLING` frames more.

        Raises:
            RuntimeError: the state still grows after 64 frames.
        """
        before: list[tuple[int, ...]] | None = None
        for _ in range(LONGEST):
            self.step()
            shapes = self.stream.shapes()
            if shapes == before:
                break
            before = shapes
        else:
            raise RuntimeError(f"its state still grows after {LONGEST} frames")
        for _ in range(SETTLING):
            self.step()

    def time(self, frames: int, seconds: float) -> list[float]:
        """Return the seconds of each of ``frames`` frames, or of those that begin within ``seconds``, at least one.

        One frame before them is not counted: other programs have filled the caches since the last frame.
        """
        self.step()
        times: list[float] = []
        while len(times) < frames and (not times or sum(times) < seconds):
            start = self._clock()
            self.step()
            times.append(self._clock() - start)
        return times
