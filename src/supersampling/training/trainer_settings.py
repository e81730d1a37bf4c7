"""The settings under ``trainer.``, checked before anything is rendered, and as a job passes them to Lightning."""

import difflib
import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import lightning as L
import torch
from lightning.pytorch.accelerators import AcceleratorRegistry
from lightning.pytorch.profilers import AdvancedProfiler, Profiler, PyTorchProfiler, SimpleProfiler
from lightning.pytorch.utilities.exceptions import MisconfigurationException
from omegaconf import DictConfig, OmegaConf

from supersampling.errors import UserError
from supersampling.training.time_limit import TimeLimit
from supersampling.training.trainer_arguments import NAMES, RESERVED, RULES, duration

BUILT_BY_JOB = ("max_time", "profiler", "devices", "strategy", "num_nodes")
"""Arguments whose objects a job builds: see `time_limits`, `profiler` and `supersampling.training.devices`."""
PROFILERS: dict[str, Callable[..., Profiler]] = {
    "simple": SimpleProfiler,
    "advanced": AdvancedProfiler,
    "pytorch": PyTorchProfiler,
}


def check_trainer(cfg: DictConfig) -> None:
    """Raise `UserError` for a setting under ``trainer.`` that Lightning or a job cannot use; nothing is computed."""
    settings = _settings(cfg)
    for name, value in settings.items():
        _check(name, value)
    _check_environment()
    _check_together(settings, int(cfg.budget.steps))
    _check_constructed(settings)


def arguments(cfg: DictConfig, clips: int) -> dict[str, Any]:
    """Return what a job passes to `lightning.Trainer`: the settings that are set, without those that it sets itself.

    Those of `BUILT_BY_JOB` are left out too. A fraction of the validation ``clips`` is at least one of them.
    """
    passed = _passed(_settings(cfg))
    limit = passed.get("limit_val_batches")
    if isinstance(limit, float) and 0 < limit <= 1:
        passed["limit_val_batches"] = max(1, int(limit * clips))
    return passed


def profiler(cfg: DictConfig, folder: Path) -> Profiler | None:
    """Return the profiler of ``trainer.profiler``, which writes to ``folder/fit-profile*``; None if none is set."""
    name = OmegaConf.select(cfg, "trainer.profiler")
    return None if name is None else PROFILERS[name](dirpath=folder, filename="profile")


def time_limits(cfg: DictConfig, checkpoint: Path) -> list[L.Callback]:
    """Return the callback of ``trainer.max_time``, which writes ``checkpoint``; none if no time is set."""
    value = OmegaConf.select(cfg, "trainer.max_time")
    limit = duration(OmegaConf.to_container(value) if OmegaConf.is_config(value) else value)
    return [] if limit is None else [TimeLimit(limit, checkpoint)]


def _passed(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {k: v for k, v in settings.items() if v is not None and k not in (*RESERVED, *BUILT_BY_JOB)}


def _settings(cfg: DictConfig) -> dict[str, Any]:
    return {str(k): v for k, v in OmegaConf.to_container(cfg.trainer, resolve=True).items()}  # type: ignore[union-attr]


def _check(name: str, value: Any) -> None:
    """Raise `UserError` for an unknown argument, one that a job sets itself, or a value that it cannot have."""
    if name not in NAMES:
        near = difflib.get_close_matches(name, NAMES, 1)
        advice = f"did you mean trainer.{near[0]}?" if near else "see docs/train.md for those that it has."
        raise UserError(f"lightning.Trainer has no argument {name} (trainer.{name}={value}): {advice}")
    reserved = RESERVED.get(name)
    if value is None:
        return
    if reserved is not None and not any(value == harmless for harmless in reserved.harmless):
        raise UserError(f"Invalid trainer.{name}={value}: {reserved.advice}.")
    rule = RULES.get(name)
    if rule is not None and not rule.allows(value):
        raise UserError(f"Invalid trainer.{name}={value}: use {rule.words}.")


def _check_environment() -> None:
    """Raise `UserError` for a variable from which Lightning would take an argument: no identity would hold it."""
    for name in NAMES:
        variable = f"PL_TRAINER_{name.upper()}"
        if os.environ.get(variable):
            raise UserError(
                f"The environment variable {variable}={os.environ[variable]} would change a training that does not "
                f"name it: unset it, and write trainer.{name}=... instead."
            )


def _check_together(settings: Mapping[str, Any], steps: int) -> None:
    """Raise `UserError` for values that exclude each other in an epoch of ``steps`` batches."""
    if settings.get("gradient_clip_algorithm") is not None and not settings.get("gradient_clip_val"):
        raise UserError(
            f"trainer.gradient_clip_algorithm={settings['gradient_clip_algorithm']} has no effect without a limit: set "
            "trainer.gradient_clip_val as well."
        )
    batches = epoch_batches(settings.get("limit_train_batches"), steps)
    if batches < 1:
        raise UserError(
            f"Invalid trainer.limit_train_batches={settings['limit_train_batches']}: it is less than one of the "
            f"budget.steps={steps} batches of an epoch, so use at least {1 / steps:g}."
        )
    interval = settings.get("val_check_interval")
    if isinstance(interval, int) and interval > batches:
        raise UserError(
            f"Invalid trainer.val_check_interval={interval}: an epoch has {batches} batches, so use at most that many, "
            "or budget.validate_every for several epochs."
        )


def epoch_batches(limit: float | None, steps: int) -> int:
    """Return the batches of an epoch of ``steps`` batches under ``limit_train_batches``."""
    if limit is None:
        return steps
    return int(steps * limit) if isinstance(limit, float) and limit <= 1 else min(steps, int(limit))


def _check_constructed(settings: Mapping[str, Any]) -> None:
    """Raise `UserError` for the first setting with which `lightning.Trainer` cannot be built on this machine."""
    values: dict[str, Any] = {}
    for name, value in _passed(settings).items():
        values[name] = value
        reason = _failure(values)
        if reason is not None:
            raise UserError(f"Invalid trainer.{name}={value} ({reason}): {_advice(name)}.")


def _failure(values: Mapping[str, Any]) -> str | None:
    """Return why `lightning.Trainer` refuses these arguments, None if it takes them."""
    with restored_flags():
        try:
            trainer = L.Trainer(
                **{"enable_progress_bar": False, **values},
                logger=False,
                enable_checkpointing=False,
                enable_model_summary=False,
            )
        except (MisconfigurationException, ValueError, TypeError, ImportError, RuntimeError) as error:
            return re.split(r"[.!]\s|\n", str(error).strip() or type(error).__name__)[0].rstrip(".:!")
    if str(values.get("precision")) in ("16", "16-mixed") and trainer.precision != "16-mixed":
        return f"Lightning would compute in {trainer.precision} on this accelerator"
    return None


def _advice(name: str) -> str:
    if name == "accelerator":
        return f"use {' or '.join(available_accelerators())}"
    if name == "precision":
        return "use bf16-mixed"
    return "use a value that this machine has; docs/train.md describes the setting"


def available_accelerators() -> list[str]:
    """Return the values of ``trainer.accelerator`` that this machine has."""
    registry = AcceleratorRegistry
    names = [name for name in registry.available_accelerators() if registry[name]["accelerator"].is_available()]
    return ["auto", *names, *(["gpu"] if {"cuda", "mps"} & set(names) else [])]


@contextmanager
def explained_failures() -> Iterator[None]:
    """Restore torch's flags, and raise `UserError` for an operation that ``trainer.deterministic=true`` rules out."""
    with restored_flags():
        try:
            yield
        except RuntimeError as error:
            if "does not have a deterministic implementation" not in str(error):
                raise
            operation = str(error).partition(" ")[0]
            raise UserError(
                f"Invalid trainer.deterministic=true: this method needs {operation}, which has no deterministic form "
                "on this device, so use trainer.deterministic=warn."
            ) from error


@contextmanager
def restored_flags() -> Iterator[None]:
    """Restore the flags of torch that `lightning.Trainer` sets for the whole process."""
    deterministic = torch.are_deterministic_algorithms_enabled()
    warn_only, benchmark = torch.is_deterministic_algorithms_warn_only_enabled(), torch.backends.cudnn.benchmark
    try:
        yield
    finally:
        torch.use_deterministic_algorithms(deterministic, warn_only=warn_only)
        torch.backends.cudnn.benchmark = benchmark
