"""Effect of a precision or a backend on quality, as it is stored and summarised."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from supersampling.runs.statistics import Estimate, bootstrap_mean

TABLE = "precision.json"
KEYS = ["method", "architecture", "backend", "precision", "machine"]


@dataclass(frozen=True, kw_only=True)
class Change:
    """Effect of one variant over ``frames`` frames of whole clips.

    Attributes:
        mean: dB, variant less float32, paired; negative for a loss.
        slope: dB per frame, of a straight line through each clip's differences: the speed of a drift.
        largest: largest difference of any pixel, in a range of 1; infinite if a value is not finite.
    """

    method: str
    architecture: str
    backend: str
    precision: str
    machine: str
    mean: Estimate
    slope: Estimate
    largest: float
    frames: int


def changes(rows: pd.DataFrame) -> list[Change]:
    """Return the changes in a table of `supersampling.profiling.drift.roll` with the columns `KEYS`, in its order."""
    return [_change(dict(zip(KEYS, key)), group) for key, group in rows.groupby(KEYS, sort=False)]


def _change(key: dict[str, Any], rows: pd.DataFrame) -> Change:
    differences = rows.assign(difference=rows["changed"].astype(float) - rows["psnr"].astype(float))
    clips = [clip for _, clip in differences.groupby(["scene", "clip"], sort=True)]
    scenes = [str(clip["scene"].iloc[0]) for clip in clips]
    largest = pd.to_numeric(rows["largest"]).fillna(np.inf)  # JSON has no infinity
    return Change(
        **key,
        mean=bootstrap_mean([float(clip["difference"].mean()) for clip in clips], scenes),
        slope=bootstrap_mean([slope(clip["frame"], clip["difference"]) for clip in clips], scenes),
        largest=float(largest.max()),
        frames=len(rows),
    )


def slope(frames: pd.Series, values: pd.Series) -> float:
    """Return the slope of the least-squares line; 0 for a single frame."""
    x = frames.to_numpy(dtype=float) - float(frames.mean())
    denominator = float((x * x).sum())
    return 0.0 if denominator == 0.0 else float((x * values.to_numpy(dtype=float)).sum() / denominator)


def costs(changes: Sequence[Change]) -> dict[tuple[str, str, str], Estimate]:
    """Return the mean by architecture, backend and precision, as `supersampling.reporting.trade` reads it.

    The last of several changes counts.
    """
    return {(c.architecture, c.backend, c.precision): c.mean for c in changes}
