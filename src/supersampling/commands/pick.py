"""The command ``pick``: the choice of a method from earlier trainings and timings."""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from supersampling.commands.typed import as_typed
from supersampling.errors import UserError
from supersampling.reporting.methods import list_methods
from supersampling.reporting.settings import choose
from supersampling.reporting.trade.front import Candidate, Place, places
from supersampling.reporting.trade.pick import Rendering, paired, sentences, within_db, within_ms
from supersampling.reporting.trade.sheets import read_trade
from supersampling.runs.estimates import indexed
from supersampling.runs.store import Run, Store


def pick(cfg: DictConfig) -> None:
    """Print the best method within ``ms``, or the fastest within ``db`` of the best, of one data set and machine.

    Settings: ``tracking_uri``, ``experiment_name``, ``dataset`` (a fingerprint's first characters), ``data`` and
    ``task.scale`` if the command line sets them, ``size`` (the target's, null for the one with most times), ``low_ms``
    and ``high_ms``.

    Raises:
        UserError: an invalid limit, both limits or none, a store, data set or size without times.
    """
    ms, db = cfg.ms, cfg.db
    if (ms is None) == (db is None):
        raise UserError(f"Invalid ms={ms} and db={db}: set exactly one of them, in milliseconds or decibels.")
    rendering = Rendering.of(cfg.low_ms, cfg.high_ms)
    with tempfile.TemporaryDirectory(prefix="pick-") as folder:
        store = Store(cfg.tracking_uri, Path(folder))
        experiment = store.experiment(str(cfg.experiment_name))
        choice = choose(_select_data(experiment.runs), as_typed(cfg, "dataset"), None)
        methods = list_methods(choice.pools[choice.setting], [])
        runs = [run for method in methods for run in method.runs]
        clips = {run: indexed(table) for run, table in store.tables(runs, "clips").items()}
        candidates = read_trade(store, experiment, methods, clips).candidates
    place, rest = _select_place(candidates, cfg.size)
    candidates = [c for c in candidates if Place.of(c.timing) == place]
    gap_of = paired(clips)
    if ms is not None:
        answer = within_ms(candidates, ms, rendering, gap_of)
    else:
        answer = within_db(candidates, db, rendering, gap_of)
    lines = [f"{choice.setting}; {place}", *sentences(answer, ms, db)]
    if rest:
        lines.append(f"There are times of other targets or machines too: {'; '.join(map(str, rest))}.")
    sys.stdout.write("\n".join(lines) + "\n")


def _select_data(runs: Sequence[Run]) -> list[Run]:
    """Return the runs of the data preset and the scale that the command line names; all if it names none."""
    if not HydraConfig.initialized():
        return list(runs)
    words = [str(word).lstrip("+~") for word in HydraConfig.get().overrides.task]
    overrides = dict(word.split("=", 1) for word in words if "=" in word)
    requested = {key: overrides[key] for key in ("data", "task.scale") if key in overrides}
    selected = [run for run in runs if all(run.params.get(key) == value for key, value in requested.items())]
    if not selected:
        known = ", ".join(sorted({run.params.get("data", "unknown") for run in runs}))
        words = [f"{key}={value}" for key, value in requested.items()]
        raise UserError(f"No finished run has {' '.join(words)}: train on it first, or choose from data={known}.")
    return selected


def _select_place(candidates: Sequence[Candidate], size: Sequence[int] | None) -> tuple[Place | None, list[Place]]:
    """Return the requested place, that with most times for ``size`` None, and the remaining ones."""
    timed = places(candidates)
    fitting = [p for p in timed if size is None or [p.width, p.height] == list(size)]
    if timed and not fitting:
        known = ", ".join(sorted({f"[{p.width},{p.height}]" for p in timed}))
        raise UserError(f"No times with size={list(size or [])}: choose from {known}.")
    selected = fitting[0] if fitting else None
    return selected, [p for p in timed if p != selected]
