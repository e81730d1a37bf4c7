"""The cost of a composition: milliseconds per frame in streaming use, and the buffers that a renderer must write."""

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

from supersampling.files import replace_file
from supersampling.frames import BUFFERS
from supersampling.models.base import Upsampler
from supersampling.profiling.backends import Eager, LoadOptions
from supersampling.profiling.stream import Streaming, cache_size, distinct_frames
from supersampling.render.measure.costs import costs
from supersampling.runs.experiment import machine
from supersampling.scenes.load import load_scene

BYTES = {"uint8": 1, "uint16": 2, "float16": 2, "float32": 4}


@dataclass(frozen=True)
class FrameTime:
    """The median time of a frame and its quartiles, in milliseconds."""

    ms: float
    low: float
    high: float


@dataclass(frozen=True)
class Size:
    """Width and height of the low-resolution input."""

    width: int
    height: int


def measure_frame_times(models: Sequence[Upsampler], size: Size, frames: int) -> list[FrameTime]:
    """Time all models in streaming use on the device of a training.

    The models take turns, so that noise of the machine affects all of them alike.
    """
    device = L.Fabric(accelerator="auto", devices=1).device
    options = LoadOptions(
        width=size.width, height=size.height, precision="float32", device=device, threads=torch.get_num_threads()
    )
    streams = []
    for model in models:
        inputs = distinct_frames(model, size.width, size.height, None, cache_size())
        streams.append(Streaming(Eager().load(copy.deepcopy(model), options), inputs, device))
        streams[-1].warm_up()
    times: list[list[float]] = [[] for _ in streams]
    for _ in range(frames):
        for model_times, stream in zip(times, streams):
            model_times += [1e3 * seconds for seconds in stream.time(1, math.inf)]
    return normalise_turns(times)


def normalise_turns(times: Sequence[Sequence[float]]) -> list[FrameTime]:
    """Return the frame times of ``times[model][turn]``: each relative to the mean of its turn, times the median turn.

    A slow turn slows all of its models alike, and so does not change their order.
    """
    turns = [statistics.fmean(turn) for turn in zip(*times)]
    median = statistics.median(turns)
    return [_frame_time([median * time / turn for time, turn in zip(row, turns)]) for row in times]


def _frame_time(times: Sequence[float]) -> FrameTime:
    low, median, high = statistics.quantiles(times, n=4) if len(times) > 1 else [times[0]] * 3
    return FrameTime(median, low, high)


def cache_key(model_config: Any, scale: int, size: Size, frames: int) -> str:
    """Return 16 hex digits that identify a composition's time: the model, how it is measured, and the machine."""
    content = [model_config, scale, asdict(size), frames, machine()]
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:16]


class TimeCache:
    """Frame times of earlier commands in a JSON file, so that a repeated search decides by the same numbers."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known = _read_times(path)

    def times(self, keys: Sequence[str], models: Sequence[Upsampler], size: Size, frames: int) -> list[FrameTime]:
        """Return the times of all models: from the file if one command measured all of them, otherwise measured now."""
        if not set(keys) <= self._known.keys():
            times = measure_frame_times(models, size, frames)
            self._known = {key: asdict(time) for key, time in zip(keys, times)}
            self._path.parent.mkdir(parents=True, exist_ok=True)
            temporary = self._path.with_name(f"{self._path.name}.part")
            temporary.write_text(json.dumps(self._known, indent=1))
            replace_file(temporary, self._path)
        return [FrameTime(**self._known[key]) for key in keys]


def _read_times(path: Path) -> dict[str, Any]:
    """Return the times in a file; none if it is missing or broken, because they can be measured again."""
    try:
        content = json.loads(path.read_text()) if path.is_file() else {}
        for entry in content.values():
            FrameTime(**entry)
    except (ValueError, TypeError, AttributeError):
        return {}
    return dict(content)


def count_bytes(name: str, size: Size, scale: int) -> int:
    """Return the bytes of a buffer of one frame, as it is stored."""
    buffer = BUFFERS[name]
    side = {"low": 1, "high": scale, "frame": 0}[buffer.resolution]
    pixels = size.width * size.height * side**2 or 1
    return buffer.channels * BYTES[buffer.dtype] * pixels


def measure_rendering(scene: str, path: str | None) -> dict[str, float]:
    """Return the seconds that each rendered buffer takes by itself.

    In a window of 256 x 256 target pixels of the scene, at a quarter of the resolution.
    """
    return {cost.name: cost.seconds for cost in costs(load_scene(scene, Path(path) if path else None))}


def buffer_rows(
    names: Iterable[str], required: Iterable[str], size: Size, scale: int, seconds: dict[str, float]
) -> list[dict[str, Any]]:
    """Return one row per buffer that some composition reads: whether it is required, its bytes, and any known time."""
    required = frozenset(required)
    return [
        {
            "buffer": name,
            "needed": name in required,
            "bytes": count_bytes(name, size, scale),
            "render_ms": 1e3 * seconds[name] if name in seconds else None,
        }
        for name in sorted(names)
    ]
