"""The change of quality by a number format or a backend, as it is stored and summarised."""

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
    """The change of quality by one variant, over ``frames`` frames of whole clips.

    Attributes:
        mean: of variant minus float32, paired, in dB; a negative one is a loss.
        slope: of a straight line through each clip's differences, in dB per frame: how fast it drifts.
        largest: difference of any pixel, of a range of 1; infinite if any pixel is not finite.
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
    """Return the changes of a table with one row per frame and the columns `KEYS`, in the table's order."""
    return [_change(dict(zip(KEYS, key)), group) for key, group in rows.groupby(KEYS, sort=False)]


def _change(keys: dict[str, Any], rows: pd.DataFrame) -> Change:
    apart = rows.assign(apart=rows["changed"].astype(float) - rows["psnr"].astype(float))
    clips = [clip for _, clip in apart.groupby(["scene", "clip"], sort=True)]
    scenes = [str(clip["scene"].iloc[0]) for clip in clips]
    # JSON has no infinity.
    largest = pd.to_numeric(rows["largest"]).fillna(np.inf)
    return Change(
        **keys,
        mean=bootstrap_mean([float(clip["apart"].mean()) for clip in clips], scenes),
        slope=bootstrap_mean([slope(clip["frame"], clip["apart"]) for clip in clips], scenes),
        largest=float(largest.max()),
        frames=len(rows),
    )


def slope(frames: pd.Series, values: pd.Series) -> float:
    """Return the slope of the straight line of least squares; 0 for a single frame."""
    x = frames.to_numpy(dtype=float) - float(frames.mean())
    squares = float((x * x).sum())
    return 0.0 if squares == 0.0 else float((x * values.to_numpy(dtype=float)).sum() / squares)


def costs(changes: Sequence[Change]) -> dict[tuple[str, str, str], Estimate]:
    """Return the mean changes by architecture, backend and precision; the last of several counts."""
    return {(c.architecture, c.backend, c.precision): c.mean for c in changes}
