"""Milliseconds of a training step of each method, their breakdown, and the overhead of the package's training loop.

    python scripts/timing/step.py                             all methods, laptop budget
    python scripts/timing/step.py model=dlctus,nsrd loss=l1   selected methods; any overrides of train.py

Prints Markdown tables. Steps compute on noise with the data's shapes; only the times of loading use the configured
data, which are rendered first if they are missing. Tests never assert speed.
"""

import io
import statistics
import sys
import time
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import Any

import lightning as L
import torch
from breakdown import PARTS, Breakdown, measure_breakdown
from case import Case, cases
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from torch.utils.data import DataLoader

from supersampling.commands.entry import run
from supersampling.training.descent import make_loaders
from supersampling.training.job import fitting_buffers
from supersampling.training.module import Training

WARM_UP = 2
# Rounds of both loops alternate, so that a drift of the machine's speed affects both equally.
ROUNDS = 3
# Duration of a round, within the limits of its number of steps.
SECONDS = 3.0
MIN_STEPS, MAX_STEPS = 5, 100
LIMIT = 1.0 / 3.0


class Starts(L.Callback):
    """Recorder of the times at which batches start."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def on_train_batch_start(self, *args: object) -> None:
        self.times.append(time.perf_counter())

    def steps(self) -> list[float]:
        """Return the seconds between consecutive starts."""
        return [b - a for a, b in zip(self.times[WARM_UP:], self.times[WARM_UP + 1 :])]


def plain_loop(cfg: DictConfig, steps: int) -> list[float]:
    case, starts = Case.from_config(cfg), Starts()
    for _ in range(steps + WARM_UP + 1):
        starts.on_train_batch_start()
        case.step()
    return starts.steps()


def training_loop(cfg: DictConfig, steps: int) -> list[float]:
    """Time the same steps in the loop of train.py, without checkpoints and the logger, which writes once per epoch."""
    case, starts = Case.from_config(cfg), Starts()
    optimizer, scheduler = instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler)
    module = Training(case.model, case.loss, optimizer, scheduler, cfg.budget.counted)
    settings: Any = OmegaConf.to_container(cfg.trainer, resolve=True)
    with redirect_stdout(io.StringIO()):
        trainer = L.Trainer(
            **{**settings, "devices": 1},
            max_epochs=1,
            limit_val_batches=0,
            logger=False,
            callbacks=[starts],
            enable_checkpointing=False,
            enable_model_summary=False,
        )
        batches: Any = [case.clip] * (steps + WARM_UP + 1)
        trainer.fit(module, train_dataloaders=DataLoader(batches, batch_size=None))
    return starts.steps()


def loading_times(cfg: DictConfig, case: Case, steps: int) -> tuple[float, float]:
    """Return the seconds per batch of creating it in this process, and of waiting for it during training steps."""
    files = instantiate(cfg.data).files(("train",), fitting_buffers(cfg))
    files = {"train": files["train"], "val": []}
    means = []
    for workers, between in ((0, lambda: None), (cfg.workers, case.step)):
        config = cfg.copy()
        config.workers, config.budget.steps = workers, steps + WARM_UP
        loader = iter(make_loaders(config, files, case.model, case.loss).train_dataloader())
        waiting = []
        for _ in range(steps + WARM_UP):
            start = time.perf_counter()
            next(loader)
            waiting.append(time.perf_counter() - start)
            between()
            if case.device.type == "cuda":
                # The rest of a step must not count as waiting.
                torch.cuda.synchronize()
        means.append(statistics.mean(waiting[WARM_UP:]))
    return means[0], means[1]


@dataclass(frozen=True, kw_only=True)
class Times:
    """Seconds of a plain step, of loading and of waiting for a batch; relative overhead of the training loop."""

    step: float
    overhead: float
    loading: float
    waiting: float
    breakdown: Breakdown


def measure_method(cfg: DictConfig) -> Times:
    first = statistics.median(plain_loop(cfg, MIN_STEPS))
    steps = max(MIN_STEPS, min(MAX_STEPS, round(SECONDS / first)))
    plain: list[float] = []
    full: list[float] = []
    for _ in range(ROUNDS):
        plain += plain_loop(cfg, steps)
        full += training_loop(cfg, steps)
    case = Case.from_config(cfg)
    loading, waiting = loading_times(cfg, case, steps)
    step = statistics.median(plain)
    return Times(
        step=step,
        overhead=statistics.median(full) / step - 1.0,
        loading=loading,
        waiting=waiting,
        breakdown=measure_breakdown(case),
    )


def percent(share: float) -> str:
    return f"{100 * share:.0f}%" if share >= 0.095 else f"{100 * share:.1f}%"


def row(*cells: str) -> None:
    print(f"| {' | '.join(cells)} |")


def header(*cells: str) -> None:
    print()
    row(*cells)
    row(*["---"] * len(cells))


def print_phases(results: dict[str, Times]) -> None:
    """Print the phases' shares of a step with its waiting; the share of convolutions is in brackets."""
    columns = ("data", "warp", "network", "loss", "backward", "optimiser")
    header("model", "ms per step", *columns, "creating a batch", "train.py's loop")
    for name, times in results.items():
        total = times.step + times.waiting
        scale, breakdown = times.step / total, times.breakdown
        warps, convolutions = breakdown.share("forward", "warp"), breakdown.share("forward", "convolutions")
        backward, backward_convolutions = breakdown.share("backward"), breakdown.share("backward", "convolutions")
        row(
            name,
            f"{1e3 * total:.0f}",
            percent(times.waiting / total),
            percent(scale * warps),
            f"{percent(scale * (breakdown.share('forward') - warps))} ({percent(scale * convolutions)})",
            percent(scale * breakdown.share("loss")),
            f"{percent(scale * backward)} ({percent(scale * backward_convolutions)})",
            percent(scale * breakdown.share("optimiser")),
            f"{1e3 * times.loading:.0f} ms",
            f"{100 * times.overhead:+.1f}%",
        )


def print_parts(results: dict[str, Times]) -> list[str]:
    """Print the parts' shares, with their backward passes; return those above `LIMIT` except convolutions."""
    large = []
    header("model", "data", *PARTS)
    for name, times in results.items():
        scale = times.step / (times.step + times.waiting)
        shares = {"data": 1.0 - scale} | {part: scale * times.breakdown.share(part=part) for part in PARTS}
        row(name, *(percent(share) for share in shares.values()))
        for part, share in shares.items():
            if share > LIMIT and part != "convolutions":
                large.append(f"- {name}, {part}, {percent(share)}: {times.breakdown.largest(part) or 'waiting'}")
    return large


def measure(configs: dict[str, DictConfig]) -> None:
    cfg = next(iter(configs.values()))
    torch.set_num_threads(cfg.threads)
    results = {}
    for name, config in configs.items():
        print(f"measuring {name}", file=sys.stderr)
        results[name] = measure_method(config)
    budget = cfg.budget
    print(
        f"{cfg.threads} threads, {cfg.workers} loading processes; batches of {budget.batch}, {budget.frames} frames, "
        f"crops of {budget.crop} pixels, {cfg.task.scale}x{cfg.task.scale}, PyTorch {torch.__version__}"
    )
    print_phases(results)
    large = print_parts(results)
    print(
        "\nMore than a third of a step, except convolutions:"
        if large
        else "\nOnly convolutions exceed a third of a step."
    )
    print("\n".join(large))


if __name__ == "__main__":
    selected: Any = cases(sys.argv[1:])
    run(measure, selected)
