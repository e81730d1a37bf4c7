"""Means and paired differences of runs' logged clip tables, with intervals over scenes, clips and seeds."""

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
    """Return the table indexed by scene and clip; at no cost if it is already."""
    return table if list(table.index.names) == PLACE else table.set_index(PLACE, drop=False)


def clip_scores(runs: Sequence[Run], metric: str, tables: ClipTables) -> pd.DataFrame | None:
    """Return a metric's values, one column per run, one row per clip ``(scene, clip)`` of which every run has a value.

    ``None`` if no run logged the metric.
    """
    scored = [tables[run.id] for run in runs if run.id in tables and metric in tables[run.id]]
    if not scored:
        return None
    columns = [indexed(table)[metric].astype(np.float64) for table in scored]
    return pd.concat(columns, axis=1, join="inner", keys=range(len(columns))).dropna().sort_index()


def estimate(runs: Sequence[Run], metric: str, tables: ClipTables) -> Estimate | None:
    """Return a metric's mean over clips and seeds with its interval; None if no run has it.

    Runs without a clip table fall back to their logged average, which has no interval.
    """
    scores = clip_scores(runs, metric, tables)
    if scores is not None and len(scores):
        return bootstrap_mean(scores.to_numpy().T, scenes_of(scores))
    return logged(runs, f"test/{metric}")


def logged(runs: Sequence[Run], metric: str) -> Estimate | None:
    """Return the mean over runs of a metric that they logged, such as ``model/parameters``; it has no interval.

    None if no run logged it.
    """
    values = [run.metrics[metric] for run in runs if metric in run.metrics]
    return Estimate(float(np.mean(values)), math.nan, math.nan, 0) if values else None


def difference(
    first: Sequence[Run], second: Sequence[Run], metric: str, tables: ClipTables, times: float = 1.0
) -> Estimate | None:
    """Return ``times * first - second`` paired over the clips that both have; ``None`` without such clips."""
    pair = _common_scores(first, second, metric, tables)
    if pair is None:
        return None
    a, b = pair
    return paired_difference(times * a.to_numpy().T, b.to_numpy().T, scenes_of(a))


def scene_differences(
    first: Sequence[Run], second: Sequence[Run], metric: str, tables: ClipTables, times: float = 1.0
) -> dict[str, float]:
    """Return each scene's mean of ``times * first - second`` over its clips and the seeds; empty without common
    clips."""
    pair = _common_scores(first, second, metric, tables)
    if pair is None:
        return {}
    a, b = pair
    means = (times * a.mean(axis=1) - b.mean(axis=1)).groupby(level="scene").mean()
    return {str(scene): float(value) for scene, value in means.items()}


def _common_scores(
    first: Sequence[Run], second: Sequence[Run], metric: str, tables: ClipTables
) -> tuple[pd.DataFrame, pd.DataFrame] | None:
    """Return both sides' scores on the clips that both have."""
    a, b = (clip_scores(runs, metric, tables) for runs in (first, second))
    if a is None or b is None:
        return None
    common = a.index.intersection(b.index).sort_values()
    return None if common.empty else (a.loc[common], b.loc[common])


def scenes_of(scores: pd.DataFrame) -> np.ndarray:
    """Return each row's scene."""
    return scores.index.get_level_values("scene").to_numpy(dtype=str)


def scaled(value: Estimate, factor: float) -> Estimate:
    """Return the mean and the interval times a positive factor."""
    return replace(value, mean=value.mean * factor, low=value.low * factor, high=value.high * factor)
