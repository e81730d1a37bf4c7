"""What ``stress.py`` does: try, print, log."""

import time
from collections.abc import Iterator, Sequence

import pandas as pd
import torch
from omegaconf import DictConfig
from tqdm import tqdm

from supersampling.errors import UserError, was_interrupted
from supersampling.stress.cell import Cell, frame_of_cells, summary
from supersampling.stress.determinism import determinism_cells
from supersampling.stress.divergence import divergence_cells
from supersampling.stress.loss import loss_cells
from supersampling.stress.memory import too_large
from supersampling.stress.plan import Budget, Chosen, budget_of, choose
from supersampling.stress.precision import INT8, Precision, chosen
from supersampling.stress.quantised import int8_cells
from supersampling.stress.recovery import recovery_cells
from supersampling.stress.rollout import rollout_cells
from supersampling.stress.source import Source, sources
from supersampling.stress.trial import cells_of
from supersampling.training.job import experiment_of

TABLE = "stress.json"
SHOWN = [
    "model",
    "extreme",
    "precision",
    "finite",
    "largest",
    "mean",
    "drift",
    "gradient",
    "value",
    "truth",
    "verdict",
    "why",
]
LARGE = 2**19  # target pixels from which memory is looked at first, and float32 alone is tried
SMALL = 6, 5  # low resolution of long roll-outs


def stress_command(cfg: DictConfig) -> bool:
    """Try the chosen models at the chosen extremes; whether every stated tolerance holds.

    Raises:
        UserError: an unknown model, extreme, precision, budget or device, or a size that is not possible.
    """
    torch.set_num_threads(cfg.threads)
    budget = budget_of(str(cfg.effort))
    size = size_of(list(cfg.size))
    device = model_device(cfg.device)
    names = None if cfg.extremes is None else [str(name) for name in cfg.extremes]
    extremes = choose(names, budget.full)
    precisions = chosen(None if cfg.precisions is None else [str(p) for p in cfg.precisions], device)
    models = budget.models if cfg.models is None else tuple(str(name) for name in cfg.models)
    tried = sources(cfg, models, device)
    experiment = experiment_of(cfg)
    started = time.monotonic()
    run = experiment.start("stress", {"ss.kind": "stress", "ss.method": ", ".join(s.name for s in tried)}, None)
    status = "FAILED"
    try:
        cells = list(all_cells(tried, extremes, precisions, budget, size, device))
        settings = {"effort": cfg.effort, "size": list(cfg.size), "device": device, "threads": cfg.threads, "seed": cfg.seed,
                    "run": cfg.run, "checkpoint": cfg.checkpoint, "models": ", ".join(s.name for s in tried)}  # fmt: skip
        experiment.log_params(run, settings)
        table = frame_of_cells(cells)
        experiment.client.log_table(run, table.astype(object).where(table.notna(), None), TABLE)
        counts = {v: float((table["verdict"] == v).sum()) for v in ("holds", "fails", "not tried")}
        experiment.log_metrics(run, {f"stress/{v.replace(' ', '_')}": n for v, n in counts.items()})
        status = "FINISHED"
    except BaseException as error:
        status = "KILLED" if was_interrupted(error) else "FAILED"
        raise
    finally:
        experiment.finish(run, status)
    _tell(table, bool(cfg.all))
    print(f"{summary(cells)}; {time.monotonic() - started:.0f} s; run {run}")
    return not counts["fails"]


def all_cells(
    tried: Sequence[Source],
    chosen: Chosen,
    precisions: Sequence[Precision],
    budget: Budget,
    size: tuple[int, int],
    device: str,
) -> Iterator[Cell]:
    """Model by model, then what belongs to none."""
    floats = [p for p in precisions if p is not INT8]
    for source in tried:
        started = time.monotonic()
        for extreme in tqdm(chosen.extremes, desc=source.name, unit="extreme", disable=None, leave=False):
            scale = extreme.scale or source.scale
            model = source.make(scale)
            if model is None:
                whole, why = source.make(source.scale), f"its weights are for scale {source.scale}"
                assert whole is not None
                yield from cells_of(source.name, whole, extreme, floats, size, device, why)
                continue
            width, height = extreme.low(size, scale)
            large = width * height * scale * scale > LARGE
            why = too_large(model, (width, height), device) if large else ""
            among = [p for p in floats if p.name == "float32"] if large else floats
            yield from cells_of(source.name, model, extreme, among or floats, size, device, why)
        own = source.make(source.scale)
        assert own is not None
        if INT8 in precisions:
            yield from int8_cells(source.name, own, chosen.extremes, size)
        if "theta" in chosen.others:
            yield from loss_cells(source.name, own, floats, size, device)
        if "recovery" in chosen.others:
            yield from recovery_cells(source.name, own, size, budget.horizon, device)
        if "determinism" in chosen.others:
            yield from determinism_cells(source.name, own, size, device)
        if "rollout" in chosen.others:
            yield from rollout_cells(source.name, own, floats, SMALL, budget.rollouts, device)
        tqdm.write(f"{source.name}: {time.monotonic() - started:.0f} s")
    if "divergence" in chosen.others:
        yield from divergence_cells(budget.divergence)


def size_of(size: Sequence[object]) -> tuple[int, int]:
    """Width and height of the low resolution where an extreme has none of its own."""
    if len(size) != 2 or not all(isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= 2**13 for n in size):
        raise UserError(
            f"size={list(size)} is not possible: use [width,height] of the low-resolution input in pixels, at most 8192."
        )
    width, height = (int(str(n)) for n in size)
    return width, height


def model_device(name: str | None) -> str:
    """The named device, or the accelerator if there is one."""
    if name is None:
        return "cuda" if torch.cuda.is_available() else "cpu"
    if name not in ("cpu", "cuda") or (name == "cuda" and not torch.cuda.is_available()):
        raise UserError(f"device={name} is not here: use device=cpu, or leave it out.")
    return str(name)


def _tell(table: pd.DataFrame, everything: bool) -> None:
    """Print the cells that do not hold, or all; recovery and divergence always."""
    own = table["extreme"].str.startswith(("recovery/", "divergence/"))
    shown = table if everything else table[(table["verdict"] == "fails") | own]
    if len(shown):
        print(shown[SHOWN].to_string(index=False, float_format=lambda v: f"{v:.3g}", na_rep=""))
