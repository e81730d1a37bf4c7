"""Made-up runs, their clips' scores, and times, for tests of the front and of picks."""

import math

import numpy as np
import pandas as pd

from supersampling.reporting.trade.front import Candidate
from supersampling.runs.statistics import Estimate
from supersampling.runs.store import Run
from supersampling.runs.timing import Timing

NO = math.nan
SCENES = ("arena", "bar", "foundry", "market", "stk/zengarden")


def run(name: str, seed: str = "0") -> Run:
    return Run(
        id=f"{name}-{seed}",
        name=name,
        identity=f"{name}-{seed}",
        dataset="aaaa",
        method=name,
        machine="machine",
        version="1",
        ended=0,
        params={"model": name, "seed": seed},
        metrics={},
    )


def timing(ms: float, name: str = "m", high: float | None = None, **more) -> Timing:
    defaults = {
        "method": name, "architecture": name, "scale": 4, "width": 1920, "height": 1080, "backend": "eager",
        "precision": "float32", "device": "cpu", "threads": 2, "machine": "a machine", "ms": ms, "low": ms,
        "high": ms if high is None else high, "frames": 20, "peak_mb": 1.0, "parameters": 1, "gmac": 1.0, "gbytes": 1.0,
        "of_product": 0.5, "of_copy": 0.5,
    }  # fmt: skip
    return Timing(**{**defaults, **more})


def candidate(name: str, db: float, ms: float, high: float | None = None, half: float = 0.1, **more) -> Candidate:
    quality = Estimate(db, db - half, db + half, 10, 5)
    return Candidate(label=name, runs=(run(name),), quality=quality, timing=timing(ms, name, high, **more))


def clip_scores(mean: float, seed: int, noise: float = 0.0, clips: int = 2) -> pd.DataFrame:
    """Scenes differ by decibels, all methods alike; ``noise`` is a method's own from scene to scene."""
    rng = np.random.default_rng(seed)
    hard = np.random.default_rng(0).normal(scale=3.0, size=(len(SCENES), clips))
    shift = rng.normal(size=len(SCENES))
    shift = noise * (shift - shift.mean())[:, None]
    values = mean + hard - hard.mean() + shift
    rows = [(scene, clip, values[s, clip]) for s, scene in enumerate(SCENES) for clip in range(clips)]
    return pd.DataFrame(rows, columns=["scene", "clip", "psnr"])
