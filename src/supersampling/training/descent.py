"""Gradient descent of one job: in this process, or in a process for each device."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import lightning as L
import torch
from hydra.utils import instantiate
from lightning.pytorch.callbacks import Timer
from lightning.pytorch.loggers import MLFlowLogger
from lightning.pytorch.utilities.rank_zero import rank_zero_only
from omegaconf import DictConfig

from supersampling.data.clips import Cut, WholeClips, WindowDataset
from supersampling.data.module import Loaders
from supersampling.errors import UserError
from supersampling.losses import Loss
from supersampling.models.base import Upsampler
from supersampling.runs.checkpoint import Carry
from supersampling.runs.checkpoint_file import WholeCheckpoints
from supersampling.training.devices import Devices
from supersampling.training.module import Training, checkpoints
from supersampling.training.processes import run_together
from supersampling.training.resume import resume_checkpoint
from supersampling.training.time_limit import position
from supersampling.training.trainer_settings import arguments, explained_failures, profiler, time_limits


@dataclass(frozen=True, kw_only=True)
class Descent:
    """The data that a process needs to train a model, alone or in a group."""

    cfg: DictConfig  # resolved, so that it can be sent to another process
    files: Mapping[str, list[Path]]
    folder: Path
    tracking_uri: str
    run_id: str
    metadata: Mapping[str, Any]
    devices: Devices

    @property
    def last(self) -> Path:
        return self.folder / "last.ckpt"

    def module(self) -> Training:
        """Return the training of the configured model, with the weights of the configured seed."""
        cfg = self.cfg
        L.seed_everything(cfg.seed, workers=True, verbose=False)
        model: Upsampler = instantiate(cfg.model)
        loss: Loss = instantiate(cfg.loss)
        return Training(model, loss, instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler), cfg.budget.counted)


def descend(descent: Descent) -> None:
    """Train until ``descent.last`` is that of the last epoch; continue from the one that exists."""
    _set_rank()
    module = descent.module()
    checkpoint = resume_checkpoint(descent.last, module)
    if descent.devices.count == 1:
        _descend(descent, module, checkpoint)
    else:
        run_together(_descend_in_group, [descent, checkpoint], descent.devices.count)
    if descent.cfg.trainer.get("profiler") is not None:
        print(f"The profile of the training is in {descent.folder} (fit-profile*).", flush=True)


def _descend_in_group(descent: Descent, checkpoint: Path | None) -> None:
    threads = max(1, descent.cfg.threads // descent.devices.count)
    os.environ["OMP_NUM_THREADS"] = str(threads)  # otherwise Lightning decides
    torch.set_num_threads(threads)
    _set_rank()
    _descend(descent, descent.module(), checkpoint)


def _set_rank() -> None:
    """Tell Lightning the rank of this process: what Slurm's variables say is not it."""
    rank_zero_only.rank = int(os.environ.get("LOCAL_RANK", 0))  # type: ignore[attr-defined]


def _descend(descent: Descent, module: Training, checkpoint: Path | None) -> None:
    """Train as the only process, or as the one that ``LOCAL_RANK`` says; the first one logs and writes."""
    cfg = descent.cfg
    timer = Timer()
    logger = MLFlowLogger(tracking_uri=descent.tracking_uri, run_id=descent.run_id)
    loaders = make_loaders(cfg, descent.files, module.model, module.loss)
    if checkpoint is not None:
        loaders.continue_at(*position(checkpoint))
    limits = time_limits(cfg, descent.last)
    with explained_failures():
        trainer = L.Trainer(
            **{**arguments(cfg, loaders.clips), **descent.devices.arguments},
            profiler=profiler(cfg, descent.folder),
            max_epochs=cfg.budget.epochs,
            check_val_every_n_epoch=cfg.budget.validate_every,
            logger=logger,
            log_every_n_steps=cfg.budget.steps,
            num_sanity_val_steps=0,
            enable_model_summary=False,
            callbacks=[timer, Carry(descent.metadata), *limits, checkpoints(descent.folder)],
        )
        trainer.strategy.checkpoint_io = WholeCheckpoints()
        trainer.fit(module, loaders, ckpt_path=checkpoint, weights_only=True)
    logger.log_metrics({"train/minutes": timer.time_elapsed("train") / 60.0})


def make_loaders(cfg: DictConfig, files: Mapping[str, list[Path]], model: Upsampler, loss: Loss) -> Loaders:
    """Return the loaders of a configuration, with the buffers that its model and loss read.

    Raises:
        UserError: the counted frames and those that the loss reads before them are more than the unrolled ones.
    """
    if cfg.budget.counted + loss.previous > cfg.budget.frames:
        raise UserError(
            f"budget.counted={cfg.budget.counted} needs more than budget.frames={cfg.budget.frames} with this loss, "
            "which reads "
            f"{loss.previous} frame before the counted ones: count fewer frames, or unroll more."
        )
    cut = Cut(cfg.budget.crop, cfg.budget.frames, cfg.budget.counted + loss.previous)
    pick, augment = instantiate(cfg.pick), instantiate(cfg.augment)
    requires = model.requires | model.compares | loss.requires | pick.requires
    train = WindowDataset(files["train"], cut, requires, pick, augment, cfg.seed)
    val = WholeClips(files["val"], requires)
    return Loaders(train, val, batch=cfg.budget.batch, steps=cfg.budget.steps, workers=cfg.workers)
