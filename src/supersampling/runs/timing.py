"""Times of methods as ``benchmark.py`` measures and logs them."""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import pandas as pd

from supersampling.runs.identity import digest, with_former_paths
from supersampling.runs.options import described

TABLE = "timings.json"
STAGES = "stages.json"
PARAMETERS = "parameters.json"
"""The run parameters of each timed architecture, one row per parameter."""
MODULES = "modules.json"
"""Parameters and multiply-accumulates of each module of each timed architecture."""
RENDERINGS = "renderings.json"
"""The renderer's time for the buffers that each timed architecture reads, by scene."""
_COLUMNS = {"reason": "why"}  # columns of the stored table that are not named as in `Timing`

# Entries of a model's configuration that cannot change its speed.
_WEIGHTS_ONLY = ("initialise",)


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Time of a method per frame in streaming use, for one target size, backend and precision, on one machine.

    Attributes:
        method: name as MLflow shows it.
        architecture: see `architecture`.
        width, height: size of the target, pixels.
        backend: eager, channels_last, compile, onnxruntime, openvino, tensorrt, native, thesis_1, thesis_1_2.
        precision: float32, bfloat16, float16, int8.
        device: cpu, cuda.
        ms: median per frame; NaN if the method does not run. ``low`` and ``high`` are quartiles over ``frames`` frames.
        peak_mb: 10^6 bytes at the peak, less those that the process used before the method was loaded.
        gmac: 10^9 multiply-accumulates per frame; NaN for a method that cannot be counted from shapes only.
        gbytes: least 10^9 bytes that a frame moves: inputs, output and weights once, state read and written.
        of_product: share of this machine's measured multiply-accumulates per second in a large matrix product of that
            precision.
        of_copy: share of its measured bytes read and written per second in a large copy.
        reason: why there is no time, in one sentence; the stored column is ``why``.
    """

    method: str
    architecture: str
    scale: int
    width: int
    height: int
    backend: str
    precision: str
    device: str
    threads: int
    machine: str
    ms: float
    low: float
    high: float
    frames: int
    peak_mb: float
    parameters: int
    gmac: float
    gbytes: float
    of_product: float
    of_copy: float
    reason: str = ""

    @property
    def runs(self) -> bool:
        """Whether the method was timed."""
        return math.isfinite(self.ms)


def architecture(model_config: Mapping[str, Any], scale: int) -> str:
    """Return 16 hex digits of a model's resolved configuration and scale: what decides its speed, not its weights."""
    return digest({"model": described(_without_weights(model_config)), "scale": int(scale)})


def former_architecture(model_config: Mapping[str, Any], scale: int) -> str:
    """Return what the first scheme called the same architecture, from the class paths."""
    return digest({"model": with_former_paths(_without_weights(model_config)), "scale": int(scale)})


def _without_weights(model_config: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in model_config.items() if key not in _WEIGHTS_ONLY}


def table(timings: Iterable[Timing]) -> pd.DataFrame:
    """Return a table with one row per timing and its attributes as columns."""
    rows = pd.DataFrame([asdict(t) for t in timings], columns=[f.name for f in fields(Timing)])
    return rows.rename(columns=_COLUMNS)


def read(path: Path) -> list[Timing]:
    """Return the timings in the file of a logged table.

    This does not use pandas' reader, which would turn an architecture of digits into a number.
    """
    content = json.loads(path.read_text())
    return timings_of(pd.DataFrame(content["data"], columns=content["columns"], dtype=object))


def timings_of(frame: pd.DataFrame) -> list[Timing]:
    """Return the timings of a `table`, with NaN for JSON's null."""
    kinds: dict[str, Any] = {f.name: f.type for f in fields(Timing)}
    rows = frame.to_dict("records")
    return [
        Timing(**{name: _convert(kind, row[_COLUMNS.get(name, name)]) for name, kind in kinds.items()}) for row in rows
    ]


def _convert(kind: type, value: Any) -> Any:
    if kind is float:
        return math.nan if value is None else float(value)
    return kind(value)
