"""``trainer.max_time``: a training that stops in time, with a checkpoint from which the same command continues."""

from datetime import timedelta
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple

import lightning as L
import torch

from supersampling.errors import TimeLimitReached


class Position(NamedTuple):
    """The batch at which a checkpoint continues: its epoch, and the batches of this epoch that are done."""

    epoch: int
    batches: int


class TimeLimit(L.Callback):
    """Stops a training by `TimeLimitReached` once it has run for ``limit``, after an optimizer step.

    Amid an epoch it writes the checkpoint first; at an epoch's end the epoch's own has just been written. The time of
    earlier processes does not count, so every process makes at least one step.
    """

    def __init__(self, limit: timedelta, checkpoint: Path) -> None:
        self._limit = limit
        self._checkpoint = checkpoint
        self._start = 0.0
        self._steps = 0

    def on_train_start(self, trainer: L.Trainer, pl_module: L.LightningModule) -> None:
        self._start = monotonic()
        self._steps = trainer.global_step

    def on_train_batch_end(
        self, trainer: L.Trainer, pl_module: L.LightningModule, outputs: Any, batch: Any, batch_idx: int
    ) -> None:
        amid_epoch = batch_idx + 1 < trainer.num_training_batches
        stepped = (batch_idx + 1) % trainer.accumulate_grad_batches == 0
        if amid_epoch and stepped and self._is_over(trainer):
            trainer.save_checkpoint(self._checkpoint, weights_only=False)
            self._stop(trainer)

    def on_train_epoch_start(self, trainer: L.Trainer, pl_module: L.LightningModule) -> None:
        if trainer.global_step > self._steps and self._is_over(trainer):
            self._stop(trainer)

    def _is_over(self, trainer: L.Trainer) -> bool:
        over: bool = trainer.strategy.broadcast(monotonic() - self._start >= self._limit.total_seconds())
        return over

    def _stop(self, trainer: L.Trainer) -> None:
        raise TimeLimitReached(
            f"Stopped by trainer.max_time={self._limit} in epoch {trainer.current_epoch}, after "
            f"{trainer.global_step} of {trainer.estimated_stepping_batches} steps: the same command continues from "
            "here."
        )


def position(checkpoint: Path) -> Position:
    """Return the position of a training checkpoint, amid an epoch or at the beginning of the one that follows."""
    loops = torch.load(checkpoint, map_location="cpu", weights_only=True, mmap=True)["loops"]["fit_loop"]
    batches = loops["epoch_loop.batch_progress"]
    done = 0 if batches["is_last_batch"] else batches["current"]["processed"]
    return Position(loops["epoch_progress"]["current"]["processed"], done)
