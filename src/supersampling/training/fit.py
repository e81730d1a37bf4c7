"""Fitting: gradient descent for a learned method, a grid on the training clips for a classical one."""

from collections.abc import Mapping
from pathlib import Path

import lightning as L
from hydra.utils import instantiate
from lightning.pytorch.callbacks import Timer
from lightning.pytorch.loggers import MLFlowLogger
from omegaconf import DictConfig, OmegaConf

from supersampling.data.clips import Cut, WholeClips, WindowDataset
from supersampling.data.module import Loaders
from supersampling.errors import UserError
from supersampling.losses import Loss
from supersampling.models.base import Upsampler
from supersampling.runs.checkpoint import Carry, load_weights, metadata
from supersampling.runs.experiment import Experiment
from supersampling.training.module import Training, checkpoints
from supersampling.training.schedule import scheduled
from supersampling.training.time_limit import position
from supersampling.training.trainer_settings import arguments, explained_failures, profiler, time_limits
from supersampling.training.tune import tune


def fit(
    cfg: DictConfig, files: Mapping[str, list[Path]], folder: Path, experiment: Experiment, run_id: str
) -> Upsampler:
    """Train the configured model, from ``folder/last.ckpt`` if it exists; log ``train/minutes`` and the checkpoint.

    The checkpoint is written after every epoch and holds weights, optimizer, schedule and counters. Samples depend on
    their index only, so an interrupted run reaches the weights of an uninterrupted one. The checkpoint also holds the
    configuration that is needed to use it: see `supersampling.runs.checkpoint`.
    """
    cfg = scheduled(cfg)
    L.seed_everything(cfg.seed, workers=True, verbose=False)
    model: Upsampler = instantiate(cfg.model)
    loss: Loss = instantiate(cfg.loss)
    module = Training(model, loss, instantiate(cfg.optimizer), instantiate(cfg.budget.scheduler), cfg.budget.counted)
    timer = Timer()
    logger = MLFlowLogger(tracking_uri=experiment.tracking_uri, run_id=run_id)
    last = folder / "last.ckpt"
    run = experiment.client.get_run(run_id).data
    loaders = make_loaders(cfg, files, model, loss)
    if last.exists():
        loaders.continue_at(*position(last))
    carry = Carry(metadata(cfg, run.tags, run.params, run_id))
    profile = profiler(cfg, folder)
    with explained_failures():
        trainer = L.Trainer(
            **arguments(cfg, loaders.clips),
            profiler=profile,
            max_epochs=cfg.budget.epochs,
            check_val_every_n_epoch=cfg.budget.validate_every,
            logger=logger,
            log_every_n_steps=cfg.budget.steps,
            num_sanity_val_steps=0,
            enable_model_summary=False,
            callbacks=[timer, carry, *time_limits(cfg, last), checkpoints(folder)],
        )
        trainer.fit(module, loaders, ckpt_path=last if last.exists() else None, weights_only=True)
    if profile is not None:
        print(f"The profile of the training is in {folder} (fit-profile*).", flush=True)
    experiment.restart(run_id, None)  # Lightning's logger has ended the run, which is still to be scored
    experiment.log_metrics(run_id, {"train/minutes": timer.time_elapsed("train") / 60.0})
    experiment.client.log_artifact(run_id, str(last), "checkpoint")
    # The trained model has the type of trainer.precision: the one that is scored is what others read.
    scored: Upsampler = instantiate(cfg.model)
    load_weights(scored, last)
    return scored


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
