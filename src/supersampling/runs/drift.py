"""What a number format or a backend changes in quality, as it is stored and summarised."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from supersampling.runs.statistics import Estimate, bootstrap_mean

TABLE = "precision.json"


KEYS = ["method", "architecture", "backend", "precision", "machine"]


@dataclass(frozen=True)
class Change:
    """What one variant changes, over ``frames`` frames of whole clips.

    Attributes:
        mean: dB, variant less float32, paired; a negative one is a loss.
        slope: dB a frame, of a straight line through each clip's differences: how fast it drifts.
        largest: difference of any pixel, of a range of 1; infinite where one is not finite.
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
    """Of a table of `roll` with the columns `KEYS` beside; the order is the table's."""
    return [_change(dict(zip(KEYS, key)), of_one) for key, of_one in rows.groupby(KEYS, sort=False)]


def _change(named: dict[str, Any], rows: pd.DataFrame) -> Change:
    apart = rows.assign(apart=rows["changed"].astype(float) - rows["psnr"].astype(float))
    clips = [clip for _, clip in apart.groupby(["scene", "clip"], sort=True)]
    scenes = [str(clip["scene"].iloc[0]) for clip in clips]
    largest = pd.to_numeric(rows["largest"]).fillna(np.inf)  # JSON knows no infinity
    return Change(
        **named,
        mean=bootstrap_mean([float(clip["apart"].mean()) for clip in clips], scenes),
        slope=bootstrap_mean([slope(clip["frame"], clip["apart"]) for clip in clips], scenes),
        largest=float(largest.max()),
        frames=len(rows),
    )


def slope(frames: pd.Series, values: pd.Series) -> float:
    """Of the straight line of least squares; 0 of a single frame."""
    x = frames.to_numpy(dtype=float) - float(frames.mean())
    below = float((x * x).sum())
    return 0.0 if below == 0.0 else float((x * values.to_numpy(dtype=float)).sum() / below)


def costs(found: Sequence[Change]) -> dict[tuple[str, str, str], Estimate]:
    """As `supersampling.reporting.trade.front.candidates` wants them; the last of several counts."""
    return {(c.architecture, c.backend, c.precision): c.mean for c in found}
