"""Fitting: gradient descent for a learned method, a grid on the training clips for a classical one."""

from collections.abc import Mapping
from pathlib import Path

from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

from supersampling.data.clips import WholeClips
from supersampling.models.base import Upsampler
from supersampling.runs.checkpoint import load_weights, metadata
from supersampling.runs.experiment import Experiment
from supersampling.training.descent import Descent, descend
from supersampling.training.devices import devices_of
from supersampling.training.schedule import scheduled
from supersampling.training.tune import tune


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
        cfg=DictConfig(OmegaConf.to_container(scheduled(cfg), resolve=True)),
        files=files,
        folder=folder,
        tracking_uri=experiment.tracking_uri,
        run_id=run_id,
        metadata=metadata(cfg, run.tags, run.params, run_id),
        devices=devices_of(cfg),
    )
    descend(descent)
    experiment.restart(run_id, None)  # Lightning's logger has ended the run, which is still to be scored
    experiment.client.log_artifact(run_id, str(descent.last), "checkpoint")
    # The trained model has the type of trainer.precision: the one that is scored is what others read.
    model: Upsampler = instantiate(cfg.model)
    load_weights(model, descent.last)
    return model


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
