"""Checks of the settings that decide a training, made once at the boundary, before anything is rendered."""

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from torch import nn

from supersampling.config import group_options
from supersampling.errors import UserError
from supersampling.runs.naming import is_learned
from supersampling.training.devices import devices_of
from supersampling.training.schedule import optimizer_steps, scheduled
from supersampling.training.trainer_settings import check_trainer

SMALLEST_RATE = 1e-12  # a training at a rate of 0 learns nothing

# Type, lowest and highest value of each key.
_NUMBERS: dict[str, tuple[type, float, float]] = {
    "seed": (int, 0, 2**32 - 1),
    "threads": (int, 1, 4096),
    "workers": (int, 0, 256),
    "task.scale": (int, 2, 6),
    "budget.epochs": (int, 1, 1e6),
    "budget.steps": (int, 1, 1e9),
    "budget.batch": (int, 1, 1e6),
    "budget.crop": (int, 8, 1e5),
    "budget.frames": (int, 1, 1e6),
    "budget.counted": (int, 1, 1e6),
    "budget.validate_every": (int, 1, 1e6),
    "budget.lr": (float, SMALLEST_RATE, 1e3),
    "optimizer.lr": (float, SMALLEST_RATE, 1e3),
}


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
        reason = str(error).splitlines()[0].rstrip(".")
        raise UserError(f"The settings of {group} cannot be used ({reason}): correct {group}.*.") from error
    end, steps = getattr(schedule, "total_steps", None), optimizer_steps(cfg)
    if end is not None and end < steps:
        raise UserError(
            f"Invalid budget.scheduler.total_steps={end}: the training takes {steps} steps, so leave the setting out."
        )


def check_numbers(cfg: DictConfig) -> None:
    """Raise `UserError` for a number of another type or outside of its range; numbers of a model or loss check
    themselves."""
    for key, (kind, low, high) in _NUMBERS.items():
        group, _, name = key.rpartition(".")
        parent = OmegaConf.select(cfg, group) if group else cfg
        if parent is None or name not in parent:
            continue
        value = OmegaConf.select(cfg, key)
        allowed = (int,) if kind is int else (int, float)
        if isinstance(value, bool) or not isinstance(value, allowed) or not low <= value <= high:
            word = "a whole number" if kind is int else "a number"
            raise UserError(f"Invalid {key}={value}: use {word} between {low:g} and {high:g}.")
    counted, frames = OmegaConf.select(cfg, "budget.counted"), OmegaConf.select(cfg, "budget.frames")
    if counted is not None and counted > frames:
        raise UserError(f"Invalid budget.counted={counted}: use at most budget.frames={frames}, or unroll more frames.")
