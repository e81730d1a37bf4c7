"""From runs' logged clip tables to means and paired differences, averaged over seeds, with intervals over clips."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from supersampling.reporting.runs import Run
from supersampling.reporting.statistics import Estimate, bootstrap_mean, paired_difference

ClipTables = Mapping[str, pd.DataFrame]


def clip_means(runs: Sequence[Run], tables: ClipTables) -> pd.DataFrame | None:
    """Mean over seeds of the logged metrics, one row a clip, indexed by ``(scene, clip)``; ``None`` if none was logged."""
    found = [tables[run.id] for run in runs if run.id in tables]
    if not found:
        return None
    return pd.concat(found).groupby(["scene", "clip"], sort=True).mean(numeric_only=True)


def estimate(runs: Sequence[Run], metric: str, tables: ClipTables) -> Estimate | None:
    """A metric's mean over clips and seeds with its interval over clips.

    Runs without a clip table fall back to their logged average, which has no interval.
    """
    clips = clip_means(runs, tables)
    if clips is not None and metric in clips:
        return bootstrap_mean(clips[metric].to_numpy(dtype=np.float64))
    logged = [run.metrics[f"test/{metric}"] for run in runs if f"test/{metric}" in run.metrics]
    return Estimate(float(np.mean(logged)), math.nan, math.nan, 0) if logged else None


def difference(
    ours: Sequence[Run], theirs: Sequence[Run], metric: str, tables: ClipTables
) -> Estimate | None:
    """``ours - theirs`` over the clips that both have, averaged over seeds; ``None`` without such clips."""
    one, other = clip_means(ours, tables), clip_means(theirs, tables)
    if one is None or other is None or metric not in one or metric not in other:
        return None
    both = one[[metric]].join(other[[metric]], how="inner", lsuffix="_ours", rsuffix="_theirs")
    values = both.to_numpy(np.float64)
    return paired_difference(values[:, 0], values[:, 1]) if len(values) else None


def scaled(value: Estimate, factor: float) -> Estimate:
    return Estimate(value.mean * factor, value.low * factor, value.high * factor, value.clips)
