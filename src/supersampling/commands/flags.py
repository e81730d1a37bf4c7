"""The flags of a command line: Hydra's own, each mistake in one sentence, and anywhere between the settings."""

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from hydra._internal.utils import get_args_parser

from supersampling import __version__
from supersampling.errors import UserError

MODES = ("run", "multirun", "cfg", "info", "shell_completion")
"""Flags that exclude each other."""

COMPLETION = {"install", "uninstall", "query"}
SHELLS = ("bash", "fish", "zsh")
DASHES = "\u2010\u2011\u2012\u2013\u2014\u2212"
"""Hyphens and dashes that word processors and web pages put in the place of a minus sign."""


@dataclass(frozen=True)
class Flags:
    """The flags that are set, and the other words of the command line.

    Attributes:
        values: True or the text of each flag that is set.
    """

    values: dict[str, Any]
    words: tuple[str, ...]

    def __contains__(self, name: str) -> bool:
        return name in self.values

    @property
    def runs(self) -> bool:
        """Return whether the command runs, and does not only print its configuration or help."""
        return not {"help", "hydra_help", "cfg", "info", "shell_completion", "experimental_rerun"} & self.values.keys()

    def arguments(self, words: Sequence[str]) -> list[str]:
        """Return the command line of these flags with other words."""
        names = {name: f"--{name.replace('_', '-')}" for name in self.values}
        flags = [names[name] if value is True else f"{names[name]}={value}" for name, value in self.values.items()]
        return [*flags, "--", *words] if words else flags


def read_flags(command: str, arguments: Sequence[str]) -> Flags:
    """Return the flags and the other words of a command line.

    Raises:
        UserError: an unknown flag, one without its value, two that exclude each other, or a folder that does not exist.
    """
    dash = next((word for word in arguments if word and word[0] in DASHES), None)
    if dash is not None:
        name = dash.lstrip(DASHES + "-")
        flag = f"-{name}" if len(name) <= 2 else f"--{name}"
        raise UserError(f"{dash} begins with a dash that is no hyphen: write {flag}.")
    parser = _parser(command)
    namespace, unknown = parser.parse_known_intermixed_args(list(arguments))
    unknown += [word for word in namespace.overrides if word.startswith("-")]
    if unknown:
        raise UserError(_unknown_flag(command, unknown[0]))
    values = {name: value for name, value in vars(namespace).items() if value not in (None, False)}
    words = tuple(values.pop("overrides", ()))
    _check(command, values, words)
    if "config_path" in values:
        values["config_path"] = _folder("config-path", values["config_path"])
    if "config_dir" in values:
        values["config_dir"] = _folder("config-dir", values["config_dir"])
    return Flags(values, words)


def _parser(command: str) -> argparse.ArgumentParser:
    """Return Hydra's parser, which raises `UserError` instead of printing its usage."""
    parser = get_args_parser()

    def error(message: str) -> NoReturn:
        raise UserError(f"Invalid flag ({message}): {command}.py --hydra-help lists the flags.")

    parser.error = error  # type: ignore[method-assign]
    for action in parser._actions:
        if isinstance(action, argparse._VersionAction):
            action.version = f"supersampling {__version__} ({action.version})"
    return parser


def _unknown_flag(command: str, word: str) -> str:
    if "=" in word:
        return f"Unknown flag {word}: write settings without dashes, {word.lstrip('-')}."
    return f"Unknown flag {word}: {command}.py --hydra-help lists the flags, {command}.py --help the settings."


def _check(command: str, values: dict[str, Any], words: Sequence[str]) -> None:
    """Raise `UserError` for flags that do not go together."""
    modes = [f"--{name.replace('_', '-')}" for name in MODES if name in values]
    if len(modes) > 1:
        raise UserError(f"{' and '.join(modes)} exclude each other: use one of them.")
    if "resolve" in values and not {"cfg", "help"} & values.keys():
        raise UserError("--resolve shows a configuration with its interpolations resolved: add --cfg job.")
    if "package" in values and "cfg" not in values:
        raise UserError(f"--package={values['package']} shows a part of a configuration: add --cfg job.")
    rerun = values.get("experimental_rerun")
    if rerun is not None and not os.path.isfile(rerun):
        raise UserError(f"--experimental-rerun={rerun} not found: name the config.pickle of a job.")
    if "shell_completion" in values:
        _check_completion(command, words)


def _check_completion(command: str, words: Sequence[str]) -> None:
    actions = [word.partition("=") for word in words]
    if len(actions) != 1 or actions[0][0] not in COMPLETION or actions[0][2] not in SHELLS:
        shells = ", ".join(f"-sc install={shell}" for shell in SHELLS)
        raise UserError(f"--shell-completion needs a shell: use {command}.py {shells}.")
    if actions[0][0] == "query" and "COMP_LINE" not in os.environ:
        raise UserError("-sc query= is what a shell calls, with the command line in the variable COMP_LINE: set it.")


def _folder(flag: str, path: str) -> str:
    """Return the absolute path of a folder; Hydra takes relative ones as parts of a package.

    Raises:
        UserError: there is no such folder.
    """
    if path.startswith("pkg://"):
        return path
    folder = os.path.abspath(os.path.expanduser(path))
    if not os.path.isdir(folder):
        raise UserError(f"--{flag}={path} is no folder: name a folder of configuration files.")
    return folder
