"""What a composition costs: milliseconds a frame in streaming use, and the buffers that it makes a renderer write."""

import copy
import hashlib
import json
import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import lightning as L
import torch

from supersampling.frames import BUFFERS
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Eager, LoadOptions
from supersampling.profiling.stream import Streaming, cache_size, distinct_frames
from supersampling.render.measure.costs import costs
from supersampling.runs.experiment import machine
from supersampling.scenes.load import load_scene

BYTES = {"uint8": 1, "uint16": 2, "float16": 2, "float32": 4}


@dataclass(frozen=True)
class Cost:
    """Median milliseconds of a frame and its quartiles."""

    ms: float
    low: float
    high: float


@dataclass(frozen=True)
class Size:
    """Width and height of the low-resolution input."""

    width: int
    height: int


def frame_times(models: Sequence[Upsampler], size: Size, frames: int) -> list[Cost]:
    """Every model in streaming use, on the device of a training, in turns, so that a noisy machine is noisy to all alike."""
    device = L.Fabric(accelerator="auto", devices=1).device
    options = LoadOptions(
        width=size.width, height=size.height, precision="float32", device=device, threads=torch.get_num_threads()
    )
    streams = []
    for model in models:
        inputs = distinct_frames(model, size.width, size.height, None, cache_size())
        streams.append(Streaming(Eager().load(copy.deepcopy(model), options), inputs, device))
        streams[-1].warm_up()
    taken: list[list[float]] = [[] for _ in streams]
    for _ in range(frames):
        for times, stream in zip(taken, streams):
            times += [1e3 * seconds for seconds in stream.time(1, math.inf)]
    return in_turns(taken)


def in_turns(taken: Sequence[Sequence[float]]) -> list[Cost]:
    """Costs of times that were taken in turns, ``taken[model][turn]``: each against its turn's mean, times the median turn.

    What slowed a whole turn slows all of its models alike, and so changes no order.
    """
    turns = [statistics.fmean(turn) for turn in zip(*taken)]
    usual = statistics.median(turns)
    return [_cost([usual * time / turn for time, turn in zip(times, turns)]) for times in taken]


def _cost(times: Sequence[float]) -> Cost:
    low, median, high = statistics.quantiles(times, n=4) if len(times) > 1 else [times[0]] * 3
    return Cost(median, low, high)


def key_of(model_config: Any, scale: int, size: Size, frames: int) -> str:
    """16 hex digits of all that decides a composition's time, and how it is measured."""
    content = [model_config, scale, asdict(size), frames, machine()]
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:16]


class Remembered:
    """Times of earlier commands, in a JSON file, so that a repeated search decides by the same numbers."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known: dict[str, Any] = json.loads(path.read_text()) if path.is_file() else {}

    def times(self, keys: Sequence[str], models: Sequence[Upsampler], size: Size, frames: int) -> list[Cost]:
        """Those of all ``models``: as they were measured, where all of them were by one command, else measured together."""
        if not set(keys) <= self._known.keys():
            found = frame_times(models, size, frames)
            self._known = {key: asdict(cost) for key, cost in zip(keys, found)}
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._path.write_text(json.dumps(self._known, indent=1))
        return [Cost(**self._known[key]) for key in keys]


def bytes_of(name: str, size: Size, scale: int) -> int:
    """Bytes of a buffer of one frame, as it is stored."""
    buffer = BUFFERS[name]
    side = {"low": 1, "high": scale, "frame": 0}[buffer.resolution]
    pixels = size.width * size.height * side**2 or 1
    return buffer.channels * BYTES[buffer.dtype] * pixels


def rendering(scene: str, path: str | None) -> dict[str, float]:
    """Seconds that each rendered buffer takes by itself in a window of 256 x 256 target pixels of a scene, at a quarter."""
    return {cost.name: cost.seconds for cost in costs(load_scene(scene, Path(path) if path else None))}


def buffer_rows(
    every: Iterable[str], needed: Iterable[str], size: Size, scale: int, seconds: dict[str, float]
) -> list[dict[str, Any]]:
    """A row for each buffer that some composition reads: whether the chosen one does, its bytes, and its seconds if known."""
    kept = frozenset(needed)
    return [
        {
            "buffer": name,
            "needed": name in kept,
            "bytes": bytes_of(name, size, scale),
            "render_ms": 1e3 * seconds[name] if name in seconds else None,
        }
        for name in sorted(every)
    ]
