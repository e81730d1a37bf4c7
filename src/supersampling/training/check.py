"""Checks of the settings that decide a training, made once at the boundary, before anything is rendered."""

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from torch import nn

from supersampling.config import group_options
from supersampling.errors import UserError, first_line
from supersampling.runs.naming import is_learned
from supersampling.training.devices import devices_of
from supersampling.training.numbers import check_numbers
from supersampling.training.schedule import optimizer_steps, scheduled
from supersampling.training.trainer_settings import check_trainer

GROUPS = ("task", "data", "model", "loss", "optimizer", "pick", "augment", "budget", "trainer", "metrics", "protocol")


def check_training(cfg: DictConfig) -> None:
    """Raise `UserError` for a group without an option, or for a number, optimizer, schedule, device or argument of
    Lightning that no training can have."""
    check_groups(cfg)
    check_numbers(cfg)
    check_trainer(cfg)
    check_schedule(cfg)
    if is_learned(instantiate(cfg.model)):
        devices_of(cfg)


def check_groups(cfg: DictConfig) -> None:
    """Raise `UserError` for a group that was set to null or to a word."""
    for group in (group for group in GROUPS if group in cfg):
        value = OmegaConf.select(cfg, group)
        if not OmegaConf.is_dict(value):
            raise UserError(f"Invalid {group}={value}: use {group}=OPTION, one of {', '.join(group_options(group))}.")


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
