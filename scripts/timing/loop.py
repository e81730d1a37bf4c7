"""Time of training besides computing: waiting for data, overhead of the loop, start-up.

    python scripts/timing/loop.py                 the default data and budget
    python scripts/timing/loop.py scene=atrium    any overrides of train.py

Prints medians over steps, for as many processor threads as train.py would use. Tests never assert speed.
"""

import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import lightning as L
import torch
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import DictConfig
from torch.utils.data import DataLoader

ROOT = Path(__file__).resolve().parents[2]
os.environ.setdefault("SUPERSAMPLING_ROOT", str(ROOT))

from supersampling.commands.entry import run  # noqa: E402
from supersampling.commands.resolvers import register  # noqa: E402
from supersampling.data.spec import SPLITS  # noqa: E402
from supersampling.training.descent import make_loaders  # noqa: E402
from supersampling.training.job import fitting_buffers  # noqa: E402
from supersampling.training.module import Training, unroll  # noqa: E402

STEPS = 30
WARM_UP = 4


def batches(cfg: DictConfig, files: dict, workers: int):
    cfg = cfg.copy()
    cfg.workers = workers
    cfg.budget.steps = STEPS + WARM_UP
    model, loss = instantiate(cfg.model), instantiate(cfg.loss)
    return make_loaders(cfg, files, model, loss)


def bare_loop(cfg: DictConfig, loader) -> tuple[list[float], list[float]]:
    """Return the seconds of computing and of waiting for each step of a minimal training loop."""
    L.seed_everything(0, verbose=False)
    model, loss = instantiate(cfg.model), instantiate(cfg.loss)
    optimizer = instantiate(cfg.optimizer)(model.parameters())
    scheduler = instantiate(cfg.budget.scheduler)(optimizer)
    outputs = cfg.budget.counted + loss.previous
    computing, waiting = [], []
    iterator = iter(loader)
    for _ in range(STEPS + WARM_UP):
        start = time.perf_counter()
        clip = next(iterator)
        ready = time.perf_counter()
        optimizer.zero_grad()
        loss(unroll(model, clip, outputs), clip["target"], {"motion": clip["motion"][:, -outputs:]}).backward()
        optimizer.step()
        scheduler.step()
        computing.append(time.perf_counter() - ready)
        waiting.append(ready - start)
    return computing[WARM_UP:], waiting[WARM_UP:]


class StepTimes(L.Callback):
    """Recorder of the times at which batches start."""

    def __init__(self) -> None:
        self.starts: list[float] = []

    def on_train_batch_start(self, *args: object) -> None:
        self.starts.append(time.perf_counter())


def lightning_loop(cfg: DictConfig, loaders) -> list[float]:
    """Return the seconds of each step of the package's training loop on the same batches."""
    L.seed_everything(0, verbose=False)
    model, loss = instantiate(cfg.model), instantiate(cfg.loss)
    module = Training(model, loss, instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler), cfg.budget.counted)
    times = StepTimes()
    trainer = L.Trainer(
        max_epochs=1,
        limit_val_batches=0,
        logger=False,
        enable_checkpointing=False,
        callbacks=[times],
        enable_model_summary=False,
        enable_progress_bar=True,
        accelerator=cfg.trainer.accelerator,
    )
    trainer.fit(module, train_dataloaders=loaders.train_dataloader())
    return [b - a for a, b in zip(times.starts[WARM_UP:], times.starts[WARM_UP + 1 :])]


def help_seconds() -> float:
    """Return the median wall time of ``python train.py --help``."""
    times = []
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run([sys.executable, str(ROOT / "train.py"), "--help"], capture_output=True, check=True)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def measure(cfg: DictConfig) -> None:
    torch.set_num_threads(cfg.threads)
    source = instantiate(cfg.data)
    files = source.files(SPLITS, fitting_buffers(cfg))
    batch = f"batch {cfg.budget.batch} of {cfg.budget.frames} frames"
    print(f"{cfg.threads} threads, {cfg.workers} loading processes, {batch}")
    in_memory = list(batches(cfg, files, workers=0).train_dataloader())
    computing, _ = bare_loop(cfg, in_memory)
    step = statistics.median(computing)
    _, waiting = bare_loop(cfg, batches(cfg, files, workers=cfg.workers).train_dataloader())
    wait = statistics.mean(waiting)
    print(f"bare loop, batches in memory      {1e3 * step:8.1f} ms per step")
    print(f"waiting for the loader            {1e3 * wait:8.1f} ms per step ({100 * wait / step:.2f}%, mean)")
    # Alternate, so that a drift of the machine's speed affects both equally.
    bare, full = [], []
    for _ in range(3):
        bare += bare_loop(cfg, in_memory)[0]
        loaders = batches(cfg, files, workers=0)
        loaders.train_dataloader = lambda: DataLoader(in_memory, batch_size=None)  # type: ignore[method-assign]
        full += lightning_loop(cfg, loaders)
    overhead = statistics.median(full) / statistics.median(bare) - 1.0
    print(
        f"train.py's loop, the same batches {1e3 * statistics.median(full):8.1f} ms per step ({100 * overhead:+.1f}%)"
    )
    print(f"python train.py --help            {help_seconds():8.2f} s")


if __name__ == "__main__":
    register()
    with initialize_config_dir(str(ROOT / "conf"), version_base="1.3"):
        run(measure, compose("train", sys.argv[1:]))
