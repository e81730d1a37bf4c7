"""The command ``stress``: every model at the extremes of its inputs, printed and logged."""

import time
from collections.abc import Iterator, Sequence

import pandas as pd
import torch
from omegaconf import DictConfig
from tqdm import tqdm

from supersampling import settings
from supersampling.errors import was_interrupted
from supersampling.runs import tables, tags
from supersampling.runs.experiment import experiment_of
from supersampling.stress.cell import COLUMNS, Cell, make_table, summarise
from supersampling.stress.determinism import determinism_cells
from supersampling.stress.divergence import divergence_cells
from supersampling.stress.loss import loss_cells
from supersampling.stress.memory import explain_too_large
from supersampling.stress.plan import BUDGETS, Budget, Selection, select_extremes
from supersampling.stress.precision import INT8, Precision, select_precisions
from supersampling.stress.quantised import int8_cells
from supersampling.stress.recovery import recovery_cells
from supersampling.stress.rollout import rollout_cells
from supersampling.stress.source import Source, load_sources
from supersampling.stress.trial import extreme_cells

TOLERANCE_STATUS = 3
LARGEST_SIDE = 2**13  # pixels
PRINTED = [column for column in COLUMNS if column not in ("size", "scale", "frames", "tolerance", "says")]
LARGE = 2**19  # target pixels above which memory is estimated first, and only float32 is tried
ROLLOUT_SIZE = 6, 5  # low resolution of long roll-outs


def stress(cfg: DictConfig) -> int:
    """Try the selected models at the selected extremes; return 0 if every stated tolerance holds, otherwise 3.

    Raises:
        UserError: a model, extreme, precision, budget or device is unknown, or a size is invalid.
    """
    torch.set_num_threads(cfg.threads)
    budget = BUDGETS[settings.choice(cfg, "effort", BUDGETS)]
    size = settings.size(cfg.size, "size", LARGEST_SIDE)
    device = settings.device(cfg.device).type
    selection = select_extremes(_names(cfg, "extremes"), budget.full)
    precisions = select_precisions(_names(cfg, "precisions"), device)
    sources = load_sources(cfg, budget.full, device)
    methods = ", ".join(source.name for source in sources)
    experiment = experiment_of(cfg)
    started = time.monotonic()
    run = experiment.start("stress", {tags.KIND: "stress", tags.METHOD: methods}, None)
    status = "FAILED"
    try:
        cells = list(all_cells(sources, selection, precisions, budget, size, device))
        parameters = {key: cfg[key] for key in ("effort", "size", "threads", "seed", "run", "checkpoint")}
        experiment.log_params(run, {**parameters, "device": device, "models": methods})
        table = make_table(cells)
        experiment.client.log_table(run, table.astype(object).where(table.notna(), None), tables.STRESS)
        counts = {v: float((table["verdict"] == v).sum()) for v in ("holds", "fails", "not tried")}
        experiment.log_metrics(run, {f"stress/{v.replace(' ', '_')}": n for v, n in counts.items()})
        status = "FINISHED"
    except BaseException as error:
        status = "KILLED" if was_interrupted(error) else "FAILED"
        raise
    finally:
        experiment.finish(run, status)
    _print_table(table, bool(cfg.all))
    print(f"{summarise(cells)}; {time.monotonic() - started:.0f} s; run {run}")
    return TOLERANCE_STATUS if counts["fails"] else 0


def _names(cfg: DictConfig, key: str) -> list[str] | None:
    return None if cfg[key] is None else [str(name) for name in cfg[key]]


def all_cells(
    sources: Sequence[Source],
    selection: Selection,
    precisions: Sequence[Precision],
    budget: Budget,
    size: tuple[int, int],
    device: str,
) -> Iterator[Cell]:
    """Yield the cells of each model, then those that belong to no model."""
    floats = [precision for precision in precisions if precision is not INT8]
    for source in sources:
        started = time.monotonic()
        name, model = source.name, source.model()
        for extreme in tqdm(selection.extremes, desc=name, unit="extreme", disable=None, leave=False):
            scale = extreme.scale or source.scale
            scaled = source.load(scale)
            if scaled is None:
                reason = f"its weights are for scale {source.scale}"
                yield from extreme_cells(name, model, extreme, floats, size, device, reason)
                continue
            width, height = extreme.low_size(size, scale)
            large = width * height * scale * scale > LARGE
            reason = explain_too_large(scaled, (width, height), device) if large else ""
            float32 = [precision for precision in floats if precision.name == "float32"] if large else []
            yield from extreme_cells(name, scaled, extreme, float32 or floats, size, device, reason)
        if INT8 in precisions:
            yield from int8_cells(name, model, selection.extremes, size)
        if "theta" in selection.groups:
            yield from loss_cells(name, model, floats, size, device)
        if "recovery" in selection.groups:
            yield from recovery_cells(name, model, size, budget.horizon, device)
        if "determinism" in selection.groups:
            yield from determinism_cells(name, model, size, device)
        if "rollout" in selection.groups:
            yield from rollout_cells(name, model, floats, ROLLOUT_SIZE, budget.rollouts, device)
        tqdm.write(f"{name}: {time.monotonic() - started:.0f} s")
    if "divergence" in selection.groups:
        yield from divergence_cells(budget.divergence)


def _print_table(table: pd.DataFrame, everything: bool) -> None:
    """Print the cells that fail, or all; recovery and divergence always."""
    always = table["extreme"].str.startswith(("recovery/", "divergence/"))
    rows = table if everything else table[(table["verdict"] == "fails") | always]
    if len(rows):
        print(rows[PRINTED].to_string(index=False, float_format=lambda v: f"{v:.3g}", na_rep=""))
