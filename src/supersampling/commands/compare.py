"""The command ``compare``: two methods over the same test clips."""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from omegaconf import DictConfig

from supersampling.commands.typed import as_typed
from supersampling.errors import UserError
from supersampling.reporting.comparison import compare, text
from supersampling.reporting.seeds import find_groups, pair
from supersampling.runs.store import Run, Store


def compare_command(cfg: DictConfig) -> None:
    """What ``compare.py`` does: print the comparison of ``cfg.a`` with ``cfg.b``."""
    wanted = {key: as_typed(cfg, key) for key in ("a", "b")}
    missing = [key for key, value in wanted.items() if value is None]
    if missing:
        raise UserError(f"{' and '.join(missing)} must be given: compare.py a=RUN_OR_METHOD b=RUN_OR_METHOD")
    with tempfile.TemporaryDirectory(prefix="compare-") as folder:
        store = Store(str(cfg.tracking_uri), Path(folder))
        runs = store.experiment(str(cfg.experiment), ("job", "evaluation")).runs
        runs = _of_dataset(runs, as_typed(cfg, "dataset"))
        a, b = pair(*(find_groups(runs, key, str(value)) for key, value in wanted.items()))
        tables = store.tables([*a.runs, *b.runs], "clips")
    names = [cfg.metric] if isinstance(cfg.metric, str) else cfg.metric
    sys.stdout.write(text(a, b, compare(a, b, tables, names), tables))


def _of_dataset(runs: Sequence[Run], start: str | None) -> list[Run]:
    found = [run for run in runs if run.dataset.startswith(start or "")]
    if not found:
        known = ", ".join(sorted({run.dataset for run in runs}))
        raise UserError(f"dataset='{start}' names no data set of the experiment: choose one of {known}")
    return found
