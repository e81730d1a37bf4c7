"""Milliseconds of a training step of each method, where they go, and what the project's loop adds to a plain one.

    python scripts/timing/step.py                             all methods, laptop budget
    python scripts/timing/step.py model=dlctus,nsrd loss=l1   some; any overrides of train.py

Prints Markdown tables. Steps compute on noise of the data's shapes; only what is said of data comes from the configured ones,
which are rendered first if they are missing. Speed is measured here, never in a test.
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
from case import Case, cases
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from torch.utils.data import DataLoader
from where import PARTS, Spent, where_it_goes

from supersampling.commands.entry import run
from supersampling.training.fit import make_loaders
from supersampling.training.job import fitting_buffers
from supersampling.training.module import Training

WARM_UP = 2
ROUNDS = 3  # of each loop, in turn, so that a drift of the machine's speed meets both alike
SECONDS = 3.0  # of steps in a round, and at least LEAST of them
LEAST, MOST = 5, 100
LIMIT = 1.0 / 3.0


class Starts(L.Callback):
    """When each batch started."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def on_train_batch_start(self, *args: object) -> None:
        self.times.append(time.perf_counter())

    def steps(self) -> list[float]:
        """Seconds from one start to the next."""
        return [b - a for a, b in zip(self.times[WARM_UP:], self.times[WARM_UP + 1 :])]


def plain_loop(cfg: DictConfig, steps: int) -> list[float]:
    case, starts = Case.of(cfg), Starts()
    for _ in range(steps + WARM_UP + 1):
        starts.on_train_batch_start()
        case.step()
    return starts.steps()


def project_loop(cfg: DictConfig, steps: int) -> list[float]:
    """Of the same steps in the loop that train.py runs, but for its logger, which writes once an epoch, and checkpoints."""
    case, starts = Case.of(cfg), Starts()
    module = Training(
        case.model,
        case.loss,
        instantiate(cfg.optimizer),
        instantiate(cfg.budget.scheduler),
        cfg.budget.counted,
    )
    settings: Any = OmegaConf.to_container(cfg.trainer, resolve=True)
    with redirect_stdout(io.StringIO()):
        trainer = L.Trainer(
            **{**settings, "devices": 1}, max_epochs=1, limit_val_batches=0, logger=False, callbacks=[starts],
            enable_checkpointing=False, enable_model_summary=False,
        )  # fmt: skip
        batches: Any = [case.clip] * (steps + WARM_UP + 1)
        trainer.fit(module, train_dataloaders=DataLoader(batches, batch_size=None))
    return starts.steps()


def data(cfg: DictConfig, case: Case, steps: int) -> tuple[float, float]:
    """Seconds a batch: of making it in this process, and of waiting for it while steps compute, as train.py loads."""
    files = instantiate(cfg.data).files(("train",), fitting_buffers(cfg))
    files = {"train": files["train"], "val": []}
    means = []
    for workers, between in ((0, lambda: None), (cfg.workers, case.step)):
        own = cfg.copy()
        own.workers, own.budget.steps = workers, steps + WARM_UP
        loader = iter(make_loaders(own, files, case.model, case.loss).train_dataloader())
        waited = []
        for _ in range(steps + WARM_UP):
            start = time.perf_counter()
            next(loader)
            waited.append(time.perf_counter() - start)
            between()
            if case.device.type == "cuda":
                torch.cuda.synchronize()  # so that what is left of a step is not taken for waiting
        means.append(statistics.mean(waited[WARM_UP:]))
    return means[0], means[1]


@dataclass(frozen=True)
class Measured:
    step: float
    overhead: float
    loading: float
    waiting: float
    spent: Spent


def measure_one(cfg: DictConfig) -> Measured:
    first = statistics.median(plain_loop(cfg, LEAST))
    steps = max(LEAST, min(MOST, round(SECONDS / first)))
    plain: list[float] = []
    ours: list[float] = []
    for _ in range(ROUNDS):
        plain += plain_loop(cfg, steps)
        ours += project_loop(cfg, steps)
    case = Case.of(cfg)
    loading, waiting = data(cfg, case, steps)
    step = statistics.median(plain)
    return Measured(step, statistics.median(ours) / step - 1.0, loading, waiting, where_it_goes(case))


def percent(share: float) -> str:
    return f"{100 * share:.0f}%" if share >= 0.095 else f"{100 * share:.1f}%"


def row(*cells: str) -> None:
    print(f"| {' | '.join(cells)} |")


def header(*cells: str) -> None:
    print()
    row(*cells)
    row(*["---"] * len(cells))


def phases(found: dict[str, Measured]) -> None:
    """Shares of a whole step, what convolutions have of them in brackets."""
    columns = ("data", "warp", "network", "loss", "backward", "optimiser")
    header("model", "ms a step", *columns, "making a batch", "train.py's loop")
    for name, m in found.items():
        whole = m.step + m.waiting
        inside, spent = m.step / whole, m.spent
        warped, convolved = spent.share("forward", "warp"), spent.share("forward", "convolutions")
        back, back_convolved = spent.share("backward"), spent.share("backward", "convolutions")
        row(
            name,
            f"{1e3 * whole:.0f}",
            percent(m.waiting / whole),
            percent(inside * warped),
            f"{percent(inside * (spent.share('forward') - warped))} ({percent(inside * convolved)})",
            percent(inside * spent.share("loss")),
            f"{percent(inside * back)} ({percent(inside * back_convolved)})",
            percent(inside * spent.share("optimiser")),
            f"{1e3 * m.loading:.0f} ms",
            f"{100 * m.overhead:+.1f}%",
        )


def parts(found: dict[str, Measured]) -> list[str]:
    """Shares by what a step does, each with its own backward; says what is above `LIMIT` and does not convolve."""
    said = []
    header("model", "data", *PARTS)
    for name, m in found.items():
        inside = m.step / (m.step + m.waiting)
        shares = {"data": 1.0 - inside} | {part: inside * m.spent.share(part=part) for part in PARTS}
        row(name, *(percent(share) for share in shares.values()))
        for part, share in shares.items():
            if share > LIMIT and part != "convolutions":
                said.append(f"- {name}, {part}, {percent(share)}: {m.spent.largest(part) or 'waiting'}")
    return said


def measure(configs: dict[str, DictConfig]) -> None:
    cfg = next(iter(configs.values()))
    torch.set_num_threads(cfg.threads)
    found = {}
    for name, config in configs.items():
        print(f"measuring {name}", file=sys.stderr)
        found[name] = measure_one(config)
    print(
        f"{cfg.threads} threads, {cfg.workers} loading processes; batches of {cfg.budget.batch}, {cfg.budget.frames} frames, "
        f"crops of {cfg.budget.crop} pixels, {cfg.task.scale}x{cfg.task.scale}, PyTorch {torch.__version__}"
    )
    phases(found)
    above = parts(found)
    print(
        "\nAbove a third of a step without being convolutions:"
        if above
        else "\nNothing but convolutions takes more than a third."
    )
    print("\n".join(above))


if __name__ == "__main__":
    chosen: Any = cases(sys.argv[1:])
    run(measure, chosen)
