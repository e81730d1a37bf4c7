"""Checks of the settings that decide a training, made once at the boundary, before anything is rendered."""

import torch
from hydra.errors import InstantiationException
from hydra.utils import get_class, instantiate
from omegaconf import DictConfig, OmegaConf
from torch import nn

from supersampling.config import group_options, option_file, published_stages, read_option
from supersampling.errors import UserError, first_line
from supersampling.models.base import Upsampler
from supersampling.runs.naming import is_learned
from supersampling.training.devices import devices_of
from supersampling.training.numbers import check_numbers
from supersampling.training.schedule import optimizer_steps, scheduled
from supersampling.training.trainer_settings import check_trainer

GROUPS = ("task", "data", "model", "loss", "optimizer", "pick", "augment", "budget", "trainer", "metrics", "protocol")


def check_training(cfg: DictConfig) -> None:
    """Raise `UserError` for a group without an option, another scale than the task's, or for a number, optimizer,
    schedule, device or argument of Lightning that no training can have."""
    check_groups(cfg)
    check_scale(cfg)
    check_numbers(cfg)
    check_trainer(cfg)
    check_schedule(cfg)
    if is_learned(instantiate(cfg.model)):
        devices_of(cfg)


def unread_jitter(cfg: DictConfig, name: str) -> str | None:
    """Return a warning if the data are jittered and the network does not read it; None if they agree.

    Args:
        name: of the model, a file of ``conf/model``.
    """
    jitter = OmegaConf.select(cfg, "data.jitter")  # files have their own
    model: Upsampler = instantiate(cfg.model)
    if jitter in (None, "none") or model.reads_jitter or not is_learned(model):
        return None
    stages = " or ".join(f"model/{slot}={option}" for slot, option in _readers_of("jitter", name))
    advice = f"set task.jitter=none, or {stages}" if stages else "set task.jitter=none"
    return f"model={name} does not read the jitter, which moves the samples of task.jitter={jitter}: {advice}."


def _readers_of(buffer: str, name: str) -> list[tuple[str, str]]:
    """Return the slots of a model with each option whose class reads a buffer."""
    options = [(slot, option) for slot in published_stages(name) for option in group_options(f"model/{slot}")]
    targets = [read_option(option_file(f"model/{slot}", option))[0].get("_target_") for slot, option in options]
    return [
        option
        for option, target in zip(options, targets)
        if target is not None and buffer in getattr(get_class(target), "requires", ())
    ]


def check_groups(cfg: DictConfig) -> None:
    """Raise `UserError` for a group that was set to null or to a word."""
    for group in (group for group in GROUPS if group in cfg):
        value = OmegaConf.select(cfg, group)
        if not OmegaConf.is_dict(value):
            raise UserError(f"Invalid {group}={value}: use {group}=OPTION, one of {', '.join(group_options(group))}.")


def check_scale(cfg: DictConfig) -> None:
    """Raise `UserError` if the model upsamples by another factor than the task: the data would not fit its output."""
    scale = OmegaConf.select(cfg, "model.scale")
    if scale is not None and scale != cfg.task.scale:
        raise UserError(
            f"model.scale={scale} differs from task.scale={cfg.task.scale}: set task.scale, which the model follows."
        )


def check_schedule(cfg: DictConfig) -> None:
    """Raise `UserError` if the optimizer or its schedule cannot be built, or the schedule ends before the training."""
    parameter = nn.Parameter(torch.zeros(2, 2))
    try:
        group = "optimizer"
        optimizer = instantiate(cfg.optimizer)([parameter])
        group = "budget.scheduler"
        schedule = instantiate(scheduled(cfg).budget.scheduler)(optimizer)
    except (InstantiationException, TypeError, ValueError, ZeroDivisionError, AttributeError) as error:
        reason = first_line(error).rstrip(".")
        raise UserError(f"The settings of {group} cannot be used ({reason}): correct {group}.*.") from error
    end, steps = getattr(schedule, "total_steps", None), optimizer_steps(cfg)
    if end is not None and end < steps:
        raise UserError(
            f"Invalid budget.scheduler.total_steps={end}: the training takes {steps} steps, so leave the setting out."
        )
