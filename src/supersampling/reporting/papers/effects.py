"""The quantity that a claim is about, of our runs: a clip's score, its score over some frames, or a logged number."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from supersampling.reporting.papers.schema import RUN_METRIC, Claim
from supersampling.runs.estimates import PLACE, ClipTables, difference, logged, scene_differences
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run


@dataclass(frozen=True)
class RunScores:
    """The tables of scores by run id: a row per clip, and a row per frame for the claims that name frames."""

    clips: ClipTables
    frames: ClipTables = field(default_factory=dict)


def effect(a: Sequence[Run], b: Sequence[Run], claim: Claim, scores: RunScores, times: float = 1.0) -> Estimate | None:
    """Return ``times * a - b`` of a claim's quantity; None without runs or values.

    A logged number has no interval. A `relative` difference is in percent of ``b``.
    """
    if not a or not b:
        return None
    if not claim.exact:
        return difference(a, b, claim.metric, quantities(claim, [*a, *b], scores), times)
    first, second = (logged(runs, claim.metric.removeprefix(RUN_METRIC)) for runs in (a, b))
    if first is None or second is None or (claim.relative and second.mean == 0):
        return None
    value = times * first.mean - second.mean
    return Estimate(100 * value / second.mean if claim.relative else value, math.nan, math.nan, 0)


def scene_effects(a: Sequence[Run], b: Sequence[Run], claim: Claim, scores: RunScores) -> dict[str, float]:
    """Return each scene's mean of ``times * a - b``; empty for a logged number."""
    if claim.exact:
        return {}
    return scene_differences(a, b, claim.metric, quantities(claim, [*a, *b], scores), claim.times)


def quantities(claim: Claim, runs: Sequence[Run], scores: RunScores) -> Mapping[str, pd.DataFrame]:
    """Return the claim's quantity by run id, one row per clip; a run without it is left out."""
    if not claim.over_frames:
        return scores.clips
    tables = {run.id: scores.frames[run.id] for run in runs if run.id in scores.frames}
    values = {run_id: of_frames(table, claim) for run_id, table in tables.items() if claim.metric in table}
    return {run_id: table for run_id, table in values.items() if len(table)}


def of_frames(table: pd.DataFrame, claim: Claim) -> pd.DataFrame:
    """Return ``scene, clip, metric`` of a table of frames: the mean over the claim's `frames`, or when it `settles`."""
    if claim.frames is not None:
        first, last = claim.frames
        table = table[(table["frame"] >= first) & (table["frame"] <= last)]
    rows = [
        (scene, clip, _value(part.sort_values("frame")[claim.metric].to_numpy(dtype=np.float64), claim))
        for (scene, clip), part in table.reset_index(drop=True).groupby(PLACE, sort=False)
    ]
    return pd.DataFrame(rows, columns=[*PLACE, claim.metric])


def _value(values: np.ndarray, claim: Claim) -> float:
    """Return the mean of a clip's values ``(frames,)``, or how many frames pass until they settle (NaN: never)."""
    if claim.settles is None:
        return float(values.mean())
    plateau = np.median(values[len(values) // 2 :])
    near = np.flatnonzero(np.abs(values - plateau) <= claim.settles)
    return float(near[0] + 1) if near.size else math.nan
