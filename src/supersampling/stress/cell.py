"""One cell of the table, and its verdict."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Literal

import numpy as np
import pandas as pd

Verdict = Literal["holds", "fails", "not tried"]


@dataclass(frozen=True, kw_only=True)
class Cell:
    """A model at an extreme in a precision; the fields are the columns of the table.

    Errors are absolute, in units of the output's range: the largest magnitude of the reference's frame, at least 1.
    ``mean`` is that of the worst frame; ``drift`` the slope of the frames' mean errors, per frame. ``value`` is a
    quantity of the extreme (frames until clean, growth per frame), ``truth`` its expected value if that is known
    independently. ``gradient`` is ``finite``, ``not finite``, or empty if no gradient was computed.
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
    gradient: str = ""
    value: float = math.nan
    truth: float = math.nan
    tolerance: str = ""
    verdict: Verdict = "not tried"
    reason: str = ""
    says: str = ""


# The stored column of a reason is ``why``.
COLUMNS = ["why" if field.name == "reason" else field.name for field in fields(Cell)]


def fit_drift(errors: Sequence[float]) -> float:
    """Return the slope of a line through the errors of frames 0, 1, ..., per frame; NaN for fewer than two frames."""
    if len(errors) < 2 or not np.isfinite(errors).all():
        return math.nan
    return float(np.polynomial.Polynomial.fit(np.arange(len(errors)), errors, 1).convert().coef[1:].sum())


def judge(finite: bool, largest: float, mean: float, gradient: str, limits: tuple[float, float]) -> tuple[Verdict, str]:
    """Return the verdict against the ``limits`` on the largest and the mean error, and the reason of a failure."""
    if not finite:
        return "fails", "not finite"
    reasons = []
    if not largest <= limits[0]:
        reasons.append(f"largest error {largest:.2g} above {limits[0]:g}")
    if not mean <= limits[1]:
        reasons.append(f"mean error {mean:.2g} above {limits[1]:g}")
    if gradient == "not finite":
        reasons.append("gradients are not finite")
    return ("fails", "; ".join(reasons)) if reasons else ("holds", "")


def make_table(cells: Sequence[Cell]) -> pd.DataFrame:
    """Return the table as it is logged: one row per cell."""
    return pd.DataFrame([list(asdict(cell).values()) for cell in cells], columns=COLUMNS)


def summarise(cells: Sequence[Cell]) -> str:
    """Return in words how many cells hold, fail and were not tried."""
    count = {verdict: sum(cell.verdict == verdict for cell in cells) for verdict in ("holds", "fails", "not tried")}
    return f"{count['holds']} cells hold, {count['fails']} fail, {count['not tried']} were not tried"
