"""Tables of what was timed: each architecture's run parameters, and the size of its modules."""

from collections.abc import Iterable, Sequence
from typing import Any

import pandas as pd
from hydra.errors import InstantiationException
from hydra.utils import instantiate

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.count import Row, count_modules
from supersampling.runs.subjects import Subject


def parameter_table(subjects: Iterable[Subject]) -> pd.DataFrame:
    """Return one row per parameter: ``architecture``, ``name``, ``value``, both text.

    Of several runs of one architecture, which may differ in their weights, the first counts.
    """
    by_architecture: dict[str, Subject] = {}
    for subject in subjects:
        by_architecture.setdefault(subject.architecture, subject)
    return pd.DataFrame(
        [
            {"architecture": key, "name": name, "value": value}
            for key, subject in by_architecture.items()
            for name, value in sorted(subject.parameters.items())
        ]
    )


def module_table(subjects: Iterable[Subject], sizes: Iterable[Sequence[int]], depth: int) -> pd.DataFrame:
    """Return one row per architecture, target size and module, as ``count.py`` counts them ``depth`` levels deep.

    Columns: ``architecture``, ``width``, ``height`` of the target, ``module``, ``kind``, ``parameters``, ``gmac`` (10^9
    multiply-accumulates per frame). A method that cannot be counted from shapes only has no rows.
    """
    rows: dict[tuple[str, int, int, str], dict[str, Any]] = {}
    for subject in subjects if depth else ():
        for width, height in sizes:
            for row in _count(subject, width // subject.scale, height // subject.scale, depth):
                key = (subject.architecture, width, height, row.module)
                rows[key] = {
                    "architecture": subject.architecture,
                    "width": width,
                    "height": height,
                    "module": row.module,
                    "kind": row.kind,
                    "parameters": row.parameters,
                    "gmac": row.macs / 1e9,
                }
    return pd.DataFrame(list(rows.values()))


def _count(subject: Subject, width: int, height: int, depth: int) -> list[Row]:
    try:
        model: Upsampler = instantiate(dict(subject.model))
        return count_modules(model, width, height, depth)
    except (UserError, InstantiationException, RuntimeError, ValueError):
        return []
