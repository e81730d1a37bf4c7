"""How long methods take, as ``benchmark.py`` measures and logs it."""

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

# Entries of a model's configuration that cannot change its speed.
_WEIGHTS_ONLY = ("initialise",)


@dataclass(frozen=True)
class Timing:
    """How long a method takes for a frame, in streaming use, of one target size, backend and precision, on one machine.

    Attributes:
        method: as MLflow shows it.
        architecture: see `architecture`.
        width, height: of the target, pixels.
        backend: eager, channels_last, compile, onnxruntime, openvino, tensorrt.
        precision: float32, bfloat16, float16, int8.
        device: cpu, cuda.
        ms: median of a frame; NaN where it does not run. ``low`` and ``high`` are its quartiles, of ``frames`` timed ones.
        peak_mb: 10^6 bytes at the peak, beyond what the process held before the method was loaded.
        gmac: 10^9 multiply-accumulates of a frame; NaN of a method that cannot be counted from shapes alone.
        gbytes: 10^9 bytes that a frame moves at least: inputs, output and weights once, state read and written.
        of_product: share of this machine's measured rate of multiply-accumulates in a large matrix product, of that precision.
        of_copy: share of its measured rate of bytes read and written in a large copy.
        why: why there is no number, one sentence.
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
    why: str = ""

    @property
    def runs(self) -> bool:
        """Whether there is a number."""
        return math.isfinite(self.ms)


def architecture(model_config: Mapping[str, Any], scale: int) -> str:
    """Return 16 hex digits of a model's resolved configuration and its scale: all that decides its speed, not its weights."""
    return digest({"model": described(_without_weights(model_config)), "scale": int(scale)})


def former_architecture(model_config: Mapping[str, Any], scale: int) -> str:
    """Return what the first scheme called the same architecture, from the class paths."""
    return digest({"model": with_former_paths(_without_weights(model_config)), "scale": int(scale)})


def _without_weights(model_config: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in model_config.items() if key not in _WEIGHTS_ONLY}


def table(timings: Iterable[Timing]) -> pd.DataFrame:
    """A row a timing, its attributes as columns."""
    return pd.DataFrame([asdict(t) for t in timings], columns=[f.name for f in fields(Timing)])


def read(path: Path) -> list[Timing]:
    """The timings of a logged table's file; pandas' own reader would take an architecture of digits for a number."""
    content = json.loads(path.read_text())
    return timings_of(pd.DataFrame(content["data"], columns=content["columns"], dtype=object))


def timings_of(frame: pd.DataFrame) -> list[Timing]:
    """What `table` was made of; what JSON has no number for is NaN again."""
    kinds: dict[str, Any] = {f.name: f.type for f in fields(Timing)}
    return [Timing(**{name: _as(kind, row[name]) for name, kind in kinds.items()}) for row in frame.to_dict("records")]


def _as(kind: type, value: Any) -> Any:
    if kind is float:
        return math.nan if value is None else float(value)
    return kind(value)
