"""The command ``compare``: two methods over the same test clips."""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from omegaconf import DictConfig

from supersampling.commands.typed import as_typed
from supersampling.errors import UserError
from supersampling.reporting import comparison
from supersampling.reporting.seeds import find_groups, pair
from supersampling.runs.store import Run, Store


def compare(cfg: DictConfig) -> None:
    """Print the comparison of ``cfg.a`` with ``cfg.b``.

    Raises:
        UserError: one of them is not set or not found, or they cannot be compared.
    """
    sides = {key: as_typed(cfg, key) for key in ("a", "b")}
    missing = [key for key, value in sides.items() if value is None]
    if missing:
        raise UserError(f"Missing {' and '.join(missing)}: use compare.py a=RUN_OR_METHOD b=RUN_OR_METHOD.")
    with tempfile.TemporaryDirectory(prefix="compare-") as folder:
        store = Store(cfg.tracking_uri, Path(folder))
        runs = store.experiment(str(cfg.experiment_name), ("job", "evaluation")).runs
        runs = _select_dataset(runs, as_typed(cfg, "dataset"))
        a, b = pair(*(find_groups(runs, key, str(value)) for key, value in sides.items()))
        tables = store.tables([*a.runs, *b.runs], "clips")
    names = [cfg.metric] if isinstance(cfg.metric, str) else cfg.metric
    sys.stdout.write(comparison.text(a, b, comparison.compare(a, b, tables, names), tables))


def _select_dataset(runs: Sequence[Run], start: str | None) -> list[Run]:
    """Return the runs of the data sets whose fingerprints begin with ``start``; all for None."""
    selected = [run for run in runs if run.dataset.startswith(start or "")]
    if not selected:
        known = ", ".join(sorted({run.dataset for run in runs}))
        raise UserError(f"No data set of the experiment begins with dataset={start}: choose one of {known}.")
    return selected
