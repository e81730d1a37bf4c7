"""One cell of the table, and its verdict."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Literal

import numpy as np
import pandas as pd

Verdict = Literal["holds", "fails", "not tried"]


@dataclass(frozen=True)
class Cell:
    """A model at an extreme in a precision.

    Errors are absolute, in units of the output's range: the largest magnitude of the reference's frame, at least 1. ``mean`` is
    that of the worst frame; ``drift`` the slope of the frames' mean errors, per frame. ``value`` is what a row has of its own
    (frames until clean, growth per frame), ``truth`` what it should be where that is known otherwise.
    """

    model: str
    extreme: str
    precision: str
    size: str
    scale: int
    frames: int
    finite: bool = True
    largest: float = math.nan
    mean: float = math.nan
    drift: float = math.nan
    gradient: str = ""  # finite, not finite, or nothing where it was not tried
    value: float = math.nan
    truth: float = math.nan
    tolerance: str = ""
    verdict: Verdict = "not tried"
    why: str = ""
    says: str = ""


COLUMNS = [field.name for field in fields(Cell)]


def drift_of(errors: Sequence[float]) -> float:
    """Slope of a straight line through the errors of frames 0, 1, ..., per frame; NaN below two frames."""
    if len(errors) < 2 or not np.isfinite(errors).all():
        return math.nan
    return float(np.polynomial.Polynomial.fit(np.arange(len(errors)), errors, 1).convert().coef[1:].sum())


def judge(finite: bool, largest: float, mean: float, gradient: str, limits: tuple[float, float]) -> tuple[Verdict, str]:
    """The verdict against the ``limits`` on the largest and the mean error, and what breaks it."""
    if not finite:
        return "fails", "not finite"
    broken = []
    if not largest <= limits[0]:
        broken.append(f"largest error {largest:.2g} above {limits[0]:g}")
    if not mean <= limits[1]:
        broken.append(f"mean error {mean:.2g} above {limits[1]:g}")
    if gradient == "not finite":
        broken.append("gradients are not finite")
    return ("fails", "; ".join(broken)) if broken else ("holds", "")


def frame_of_cells(cells: Sequence[Cell]) -> pd.DataFrame:
    """The table as it is logged: a row a cell."""
    return pd.DataFrame([asdict(cell) for cell in cells], columns=COLUMNS)


def summary(cells: Sequence[Cell]) -> str:
    """How many hold, fail and were not tried, in words."""
    count = {verdict: sum(cell.verdict == verdict for cell in cells) for verdict in ("holds", "fails", "not tried")}
    return f"{count['holds']} cells hold, {count['fails']} fail, {count['not tried']} were not tried"
