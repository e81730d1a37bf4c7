"""From runs' logged clip tables to means and paired differences with intervals over scenes, clips and seeds."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from supersampling.runs.statistics import Estimate, bootstrap_mean, paired_difference
from supersampling.runs.store import Run

ClipTables = Mapping[str, pd.DataFrame]
PLACE = ["scene", "clip"]


def indexed(table: pd.DataFrame) -> pd.DataFrame:
    """The table by scene and clip; at no cost if it is already."""
    return table if list(table.index.names) == PLACE else table.set_index(PLACE, drop=False)


def clip_scores(runs: Sequence[Run], metric: str, tables: ClipTables) -> pd.DataFrame | None:
    """A metric's values, a row for each clip ``(scene, clip)`` that every run has a value of, a column for each run.

    ``None`` where no run logged the metric.
    """
    having = [tables[run.id] for run in runs if run.id in tables and metric in tables[run.id]]
    if not having:
        return None
    columns = [indexed(table)[metric].astype(np.float64) for table in having]
    return pd.concat(columns, axis=1, join="inner", keys=range(len(columns))).dropna().sort_index()


def estimate(runs: Sequence[Run], metric: str, tables: ClipTables) -> Estimate | None:
    """A metric's mean over clips and seeds with its interval.

    Runs without a clip table fall back to their logged average, which has no interval.
    """
    scores = clip_scores(runs, metric, tables)
    if scores is not None and len(scores):
        return bootstrap_mean(scores.to_numpy().T, scenes_of(scores))
    return logged(runs, f"test/{metric}")


def logged(runs: Sequence[Run], metric: str) -> Estimate | None:
    """The mean over runs of a metric that they logged themselves, such as ``model/parameters``; it has no interval."""
    values = [run.metrics[metric] for run in runs if metric in run.metrics]
    return Estimate(float(np.mean(values)), math.nan, math.nan, 0) if values else None


def difference(ours: Sequence[Run], theirs: Sequence[Run], metric: str, tables: ClipTables) -> Estimate | None:
    """``ours - theirs`` over the clips that both have, paired over clips; ``None`` without such clips."""
    both = _paired(ours, theirs, metric, tables)
    if both is None:
        return None
    one, other = both
    return paired_difference(one.to_numpy().T, other.to_numpy().T, scenes_of(one))


def scene_differences(ours: Sequence[Run], theirs: Sequence[Run], metric: str, tables: ClipTables) -> dict[str, float]:
    """Each scene's mean of ``ours - theirs`` over its clips and the seeds; empty without common clips."""
    both = _paired(ours, theirs, metric, tables)
    if both is None:
        return {}
    one, other = both
    means = (one.mean(axis=1) - other.mean(axis=1)).groupby(level="scene").mean()
    return {str(scene): float(value) for scene, value in means.items()}


def _paired(
    ours: Sequence[Run], theirs: Sequence[Run], metric: str, tables: ClipTables
) -> tuple[pd.DataFrame, pd.DataFrame] | None:
    """Both sides' scores on the clips that both have."""
    one, other = (clip_scores(runs, metric, tables) for runs in (ours, theirs))
    if one is None or other is None:
        return None
    common = one.index.intersection(other.index).sort_values()
    return None if common.empty else (one.loc[common], other.loc[common])


def scenes_of(scores: pd.DataFrame) -> np.ndarray:
    """Each row's scene."""
    return scores.index.get_level_values("scene").to_numpy(dtype=str)


def scaled(value: Estimate, factor: float) -> Estimate:
    return replace(value, mean=value.mean * factor, low=value.low * factor, high=value.high * factor)
