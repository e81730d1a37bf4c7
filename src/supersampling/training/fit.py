"""Fitting: gradient descent for a learned method, a grid on the training clips for a classical one."""

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
from omegaconf import DictConfig, OmegaConf

from supersampling.data.clips import Cut, WholeClips, WindowDataset
from supersampling.data.module import Loaders
from supersampling.errors import UserError
from supersampling.losses import Loss
from supersampling.models.base import Upsampler
from supersampling.runs.checkpoint import Carry, load_weights, metadata
from supersampling.runs.experiment import Experiment
from supersampling.training.devices import Devices, devices_of
from supersampling.training.module import Training, checkpoints
from supersampling.training.processes import run_together
from supersampling.training.tune import tune


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


def fit(
    cfg: DictConfig, files: Mapping[str, list[Path]], folder: Path, experiment: Experiment, run_id: str
) -> Upsampler:
    """Train the configured model, from ``folder/last.ckpt`` if it exists; log ``train/minutes`` and the checkpoint.

    The checkpoint is written after every epoch and holds weights, optimizer, schedule and counters. Samples depend on
    their index only, so an interrupted run reaches the weights of an uninterrupted one, and a run on several devices
    those of one device up to rounding. The checkpoint also holds the configuration that is needed to use it: see
    `supersampling.runs.checkpoint`.
    """
    run = experiment.client.get_run(run_id).data
    descent = Descent(
        cfg=DictConfig(OmegaConf.to_container(cfg, resolve=True)),
        files=files,
        folder=folder,
        tracking_uri=experiment.tracking_uri,
        run_id=run_id,
        metadata=metadata(cfg, run.tags, run.params, run_id),
        devices=devices_of(cfg),
    )
    model = descend(descent) if descent.devices.count == 1 else descend_together(descent)
    experiment.restart(run_id, None)  # Lightning's logger has ended the run, which is still to be scored
    experiment.client.log_artifact(run_id, str(descent.last), "checkpoint")
    return model


def descend_together(descent: Descent) -> Upsampler:
    """Train in a process for each device, and return the model with the weights of the checkpoint."""
    run_together(_descend_in_group, [descent], descent.devices.count)
    model: Upsampler = instantiate(descent.cfg.model)
    load_weights(model, descent.last)
    return model


def _descend_in_group(descent: Descent) -> None:
    threads = max(1, descent.cfg.threads // descent.devices.count)
    os.environ["OMP_NUM_THREADS"] = str(threads)  # otherwise Lightning decides
    torch.set_num_threads(threads)
    descend(descent)


def descend(descent: Descent) -> Upsampler:
    """Train as the only process, or as the one that ``LOCAL_RANK`` says; the first one logs and writes."""
    cfg = descent.cfg
    # What Slurm's variables say is not the rank.
    rank_zero_only.rank = int(os.environ.get("LOCAL_RANK", 0))  # type: ignore[attr-defined]
    L.seed_everything(cfg.seed, workers=True, verbose=False)
    model: Upsampler = instantiate(cfg.model)
    loss: Loss = instantiate(cfg.loss)
    module = Training(model, loss, instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler), cfg.budget.counted)
    timer = Timer()
    logger = MLFlowLogger(tracking_uri=descent.tracking_uri, run_id=descent.run_id)
    trainer = L.Trainer(
        **{**OmegaConf.to_container(cfg.trainer), **descent.devices.arguments},  # type: ignore[dict-item]
        max_epochs=cfg.budget.epochs,
        check_val_every_n_epoch=cfg.budget.validate_every,
        logger=logger,
        log_every_n_steps=cfg.budget.steps,
        num_sanity_val_steps=0,
        enable_model_summary=False,
        callbacks=[timer, Carry(descent.metadata), checkpoints(descent.folder)],
    )
    loaders = make_loaders(cfg, descent.files, model, loss)
    last = descent.last if descent.last.exists() else None
    trainer.fit(module, loaders, ckpt_path=last, weights_only=True)
    logger.log_metrics({"train/minutes": timer.time_elapsed("train") / 60.0})
    return model


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


def choose_constants(cfg: DictConfig, train_files: list[Path]) -> tuple[Upsampler, dict[str, float]]:
    """Return a classical method with the constants of ``cfg.tune.grid`` that score best on the training clips."""
    grid = OmegaConf.select(cfg, "tune.grid") or {}

    def build(constants: Mapping[str, float]) -> Upsampler:
        return instantiate(cfg.model, **constants)

    if not grid:
        return build({}), {}
    clips = WholeClips(train_files, build({}).requires)
    best, _ = tune(build, OmegaConf.to_container(grid), clips)  # type: ignore[arg-type]
    return build(best), best
