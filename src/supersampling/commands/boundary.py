"""Checks of a composed configuration before a command uses it."""

import re
import sys
import traceback
from typing import Any

from hydra import compose
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import InstantiationException
from hydra.experimental.callback import Callback
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf, open_dict
from omegaconf.errors import ConfigAttributeError, ConfigKeyError, OmegaConfBaseException

from supersampling.commands.explanation import explanation, owners, raised_by_libraries, reason_of
from supersampling.config import composed, key_of, overrides_of, typed_overrides
from supersampling.errors import UserError, find_user_error
from supersampling.process import prepare_process, silence_libraries
from supersampling.training.numbers import check_numbers


def check_configuration(cfg: DictConfig, command: str) -> None:
    """Raise `UserError` for a missing part, a reference to a missing key or variable, and a number out of its range."""
    if HydraConfig.get().job.config_name != command:
        _check_parts(cfg, command)
    try:
        check_numbers(cfg)
        OmegaConf.resolve(cfg.copy())
        missing = sorted(OmegaConf.missing_keys(cfg))
        if missing:
            raise UserError(f"{missing[0]} has no value (???): set it to one.")
    except RecursionError as error:
        raise UserError("The settings refer to each other in a circle: set one of them to a value.") from error
    except OmegaConfBaseException as error:
        user_error = find_user_error(error)
        if user_error is not None:
            raise user_error from error
        if not raised_by_libraries(error):
            raise
        raise UserError(_unresolved(error, typed_overrides())) from error


def _unresolved(error: OmegaConfBaseException, typed: list[str]) -> str:
    """Return the sentence for a reference that leads nowhere."""
    deleted = " ".join(word for word in typed if word.startswith("~"))
    words = " ".join(word for word in typed if "${" in word)
    if deleted and not words:
        return f"{deleted} deletes what other settings refer to ({reason_of(error)}): leave it out."
    subject = words or error.full_key or "A setting"
    return (
        f"{subject} cannot be resolved ({reason_of(error)}): correct the name after ${{, or write "
        r"\${ for these characters themselves."
    )


def _check_parts(cfg: DictConfig, command: str) -> None:
    """Raise `UserError` if a configuration of ``--config-name`` lacks what the command reads."""
    missing = sorted(str(key) for key in composed(command, []).cfg if key not in cfg)
    if missing:
        name = HydraConfig.get().job.config_name
        keys = ", ".join(missing)
        raise UserError(f"--config-name={name} has no {keys}, which {command}.py reads: add {command} to its defaults.")


_REJECTIONS = (TypeError, ValueError, ImportError, type(None))
"""Causes of a part that cannot be made: a setting that a class does not take, or a ``_target_`` that does not exist."""


def explain(error: BaseException) -> UserError | None:
    """Return the mistake of the user that made a part of a command fail: a setting that was deleted or added, or
    whose value a class does not take. None if the error is ours.
    """
    typed = typed_overrides()
    key = getattr(error, "full_key", None)
    if isinstance(error, (ConfigAttributeError, ConfigKeyError)) and f"~{key}" in (_deleted(word) for word in typed):
        return UserError(f"~{key} deletes a setting that the command needs: leave it out.")
    # Without a cause it is Hydra's own complaint.
    if isinstance(error, InstantiationException) and isinstance(error.__cause__, _REJECTIONS):
        return _rejected_settings(error, typed)
    return None


def _deleted(word: str) -> str:
    return f"~{key_of(word)}" if word.startswith("~") else ""


def _rejected_settings(error: InstantiationException, typed: list[str]) -> UserError | None:
    """Return the sentence for settings of the command line that a class does not take; None if none concerns it."""
    match = re.search(r"full_key: ([\w.]+)", str(error))
    node = match[1] if match else ""
    words = [word for word in typed if node and _changes_inside(word, node)]
    if not words:
        return None
    reason = reason_of(error.__cause__) if error.__cause__ is not None else reason_of(error)
    having = [f"{node}={option}" for word in words for option in owners(node, key_of(word).removeprefix(f"{node}."))]
    advice = f"set {' or '.join(having)}" if having else "correct it"
    return UserError(f"{' '.join(words)} cannot be used ({reason}): {advice}, or leave it out.")


def _changes_inside(word: str, node: str) -> bool:
    """Return whether a word sets or deletes a setting or a slot inside of a part, or sets all of it, ``{...}``."""
    key = key_of(word).replace("/", ".")
    return key.startswith(f"{node}.") or (key == node and word.partition("=")[2].startswith("{"))


class SweepCheck(Callback):
    """Composes and checks the jobs of a multirun before the first one runs."""

    def on_multirun_start(self, config: DictConfig, **kwargs: Any) -> None:
        from supersampling.commands.entry import exit_with

        prepare_process()
        name, words = str(kwargs["config_name"]), overrides_of(config.hydra)
        try:
            self._check(config, name, words)
        except UserError as error:
            exit_with(error)
        except Exception as error:  # Hydra would make a warning of it and go on
            if not raised_by_libraries(error):
                traceback.print_exception(error)
                sys.exit(1)
            exit_with(UserError(explanation(name, words, error)))

    def _check(self, config: DictConfig, name: str, words: list[str]) -> None:
        jobs = _jobs(config, words)
        if not jobs:
            raise UserError(f"{' '.join(words)} runs no job: a list or pattern of it is empty.")
        parts: set[str] = set()
        for job in jobs:
            cfg = compose(name, job, return_hydra_config=True)
            HydraConfig.instance().set_config(cfg)
            with open_dict(cfg):
                del cfg["hydra"]
            try:
                check_configuration(cfg, name)
                _check_numbers_of_parts(cfg, job, parts)
                if name == "train":
                    _check_training(cfg, parts)
            except UserError as error:
                shared = set.intersection(*map(set, jobs))
                differing = [word for word in job if word not in shared] or job
                raise UserError(f"{' '.join(differing)}: {error} No job was started.") from error
            finally:
                HydraConfig.instance().cfg = None


def _jobs(config: DictConfig, words: list[str]) -> list[list[str]]:
    """Return the overrides of each job of a sweep; an empty list for a sweeper of another kind."""
    parameters = [f"{key}={value}" for key, value in (config.hydra.sweeper.get("params") or {}).items()]
    overrides = OverridesParser.create(GlobalHydra.instance().config_loader()).parse_overrides([*parameters, *words])
    return BasicSweeper.split_arguments(overrides, None)[0]


def _check_training(cfg: DictConfig, parts: set[str]) -> None:
    """Check how a job is trained, each way once."""
    from supersampling.training.check import check_training  # with torch and Lightning, which --help does not need

    silence_libraries()
    text = "".join(OmegaConf.to_yaml(cfg[key], resolve=True) for key in ("trainer", "budget", "optimizer"))
    if text not in parts:
        parts.add(text)
        check_training(cfg)


def _check_numbers_of_parts(cfg: DictConfig, words: list[str], parts: set[str]) -> None:
    """Raise the `UserError` of a loss or model that does not take its settings; each is tried once.

    A part whose settings are the configured ones is left alone: to make it may load weights.
    """
    for key in ("loss", "model"):
        text = OmegaConf.to_yaml(cfg[key], resolve=True) if key in cfg else ""
        if not text or text in parts or not any(word.startswith(f"{key}.") for word in words):
            continue
        parts.add(text)
        try:
            instantiate(cfg[key])
        except InstantiationException as error:
            user_error = find_user_error(error)
            if user_error is not None:
                raise user_error from error
