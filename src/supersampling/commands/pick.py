"""``pick.ms=`` and ``pick.db=`` of ``benchmark.py``: the answer from what was trained and timed before."""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from supersampling.commands.typed import as_typed
from supersampling.errors import UserError
from supersampling.reporting.pages import overview
from supersampling.reporting.settings import choose
from supersampling.reporting.trade import pick
from supersampling.reporting.trade import sheets as trade
from supersampling.reporting.trade.front import Candidate, Place, places
from supersampling.runs.estimates import indexed
from supersampling.runs.store import Run, Store


def wants_pick(cfg: DictConfig) -> bool:
    """Whether the command line asks for a pick."""
    return cfg.pick.ms is not None or cfg.pick.db is not None


def pick_command(cfg: DictConfig) -> pick.Answer:
    """Print the best method within ``pick.ms``, or the fastest within ``pick.db`` of the best, of one data set on one machine.

    Read are ``logger.tracking_uri``, ``logger.experiment``, ``dataset`` (a fingerprint's first characters), ``data`` where the
    command line has it, ``pick.size`` (the target's, null for the one with most times), ``render.low_ms`` and ``render.high_ms``.

    Raises:
        UserError: a budget that is impossible, both or none of them, a store, data set or size without times.
    """
    ms, db = cfg.pick.ms, cfg.pick.db
    if (ms is None) == (db is None):
        raise UserError(f"pick.ms={ms} and pick.db={db}: give one of them, milliseconds or decibels.")
    rendering = pick.Rendering.of(cfg.render.low_ms, cfg.render.high_ms)
    with tempfile.TemporaryDirectory(prefix="pick-") as folder:
        store = Store(str(cfg.logger.tracking_uri), Path(folder))
        experiment = store.experiment(str(cfg.logger.experiment))
        choice = choose(_of_data(experiment.runs), as_typed(cfg, "dataset"), None)
        methods = overview.methods(choice.pools[choice.setting], [])
        runs = [run for method in methods for run in method.runs]
        clips = {run: indexed(table) for run, table in store.tables(runs, "clips").items()}
        found = trade.read(store, experiment, methods, clips).found
    place, others = _place(found, cfg.pick.size)
    here = [c for c in found if Place.of(c.timing) == place]
    gap_of = pick.paired(clips)
    answer = (
        pick.within_ms(here, ms, rendering, gap_of) if ms is not None else pick.within_db(here, db, rendering, gap_of)
    )
    lines = [f"{choice.setting}; {place}", *pick.sentences(answer, ms, db)]
    if others:
        lines.append(f"There are times of other targets or machines too: {'; '.join(map(str, others))}.")
    sys.stdout.write("\n".join(lines) + "\n")
    return answer


def _of_data(runs: Sequence[Run]) -> list[Run]:
    """Those of the data preset and the scale that the command line names, all where it names none."""
    if not HydraConfig.initialized():
        return list(runs)
    hydra = HydraConfig.get()
    given = dict(str(o).lstrip("+~").split("=", 1) for o in hydra.overrides.task if "=" in str(o))
    wanted = {key: given[key] for key in ("data", "task.scale") if key in given}
    found = [run for run in runs if all(run.params.get(key) == value for key, value in wanted.items())]
    if not found:
        known = ", ".join(sorted({run.params.get("data", "unknown") for run in runs}))
        said = " ".join(f"{key}={value}" for key, value in wanted.items())
        raise UserError(f"{said} has no finished run: train on it first, or choose from data={known}.")
    return found


def _place(found: Sequence[Candidate], size: Sequence[int] | None) -> tuple[Place | None, list[Place]]:
    """The place that is asked for, the one with most times; and the others."""
    every = places(found)
    fitting = [p for p in every if size is None or [p.width, p.height] == list(size)]
    if every and not fitting:
        known = ", ".join(sorted({f"[{p.width},{p.height}]" for p in every}))
        raise UserError(f"pick.size={list(size or [])} was not timed: choose from {known}.")
    chosen = fitting[0] if fitting else None
    return chosen, [p for p in every if p != chosen]
