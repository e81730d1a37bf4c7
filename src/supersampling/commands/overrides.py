"""Wrong switches on a command line, each answered by one sentence before anything is composed."""

import re
import shlex
from collections.abc import Sequence

from supersampling.commands.quoting import is_key, parse, shell_word
from supersampling.config import group_options
from supersampling.errors import UserError
from supersampling.runs.keys import KEYS

MOVED = {
    "logger.tracking_uri": "tracking_uri",
    "logger.experiment": "experiment_name",
    "pick.ms": "pick.py ms",
    "pick.db": "pick.py db",
    "import": "import_capture.py layout",
    "export": "export_capture.py layout",
}
"""Keys of earlier versions, and what to write today."""


OPTIONAL = ("experiment", "debug", "sweeps", "tune")
"""Groups of which a command needs no option."""


def with_additions(command: str, arguments: Sequence[str]) -> list[str]:
    """Return the arguments with ``trainer.KEY=...`` as ``++trainer.KEY=...``, which sets a key or adds it.

    `lightning.Trainer` has more arguments than ``conf/trainer`` names; `supersampling.training.check` knows them all.
    """
    if command not in ("train", "advise"):
        return list(arguments)
    return [re.sub(r"^\+?(?=trainer\.\w+=)", "++", word) for word in arguments]


def check_overrides(command: str, arguments: Sequence[str]) -> None:
    """Raise `UserError` for a switch that Hydra would misread or report in its own words.

    ``model.warp_at=low`` would replace a configured stage by a word; ``model/reproject=cubic`` is no option.
    """
    adds_options = _adds_options(arguments)
    for word in (word for word in arguments if not word.startswith("-")):
        _check_form(word)
        key, _, value = word.lstrip("+~").partition("=")
        key = key.partition("@")[0]
        if key in MOVED and not (key in ("import", "export") and command != "render"):
            raise UserError(f"{key}={value} is not a setting of {command}.py: write {MOVED[key]}={value}.")
        group = key.replace(".", "/")
        options = group_options(group)
        if "." in key and options and not value.startswith("{"):
            raise UserError(
                f"{word} puts a word in the place of a configured part: write {group}={value}, with a slash."
            )
        if options and "." not in key and not adds_options and not word.startswith("~"):
            for option in _simple_values(value):
                if option not in options:
                    raise UserError(f"Unknown option {key}={option}: use {', '.join(options)}.")


def _adds_options(arguments: Sequence[str]) -> bool:
    """Return whether the command line names folders with options of the user's own: then only Hydra knows them all."""
    return any(word.startswith(("--config-dir", "-cd", "--config-path", "hydra.searchpath=")) for word in arguments)


def _simple_values(value: str) -> list[str]:
    """Return the options of ``a,b``, none of what needs Hydra's own grammar."""
    return value.split(",") if re.fullmatch(r"[\w,]+", value) else []


def without_null(word: str) -> str:
    """Return ``~experiment`` for ``experiment=null``: Hydra has no word of its own for a group without an option."""
    key, _, value = word.partition("=")
    return f"~{key}" if value.lower() == "null" and key in OPTIONAL else word


def _check_form(word: str) -> None:
    """Raise `UserError` for a word that is no ``key=value``."""
    key, sign, value = word.partition("=")
    if not word.strip():
        raise UserError("An empty word is no setting: leave it out, or write key=value.")
    if not sign and not word.startswith("~"):
        raise UserError(f"{word} is no setting: {_setting_of(word)}.")
    if key != key.strip() or not key.strip("+~@"):
        raise UserError(f"{word} is no setting: write key=value, without spaces around the equals sign.")
    if not is_key(key):
        raise UserError(f"{word} is no setting: {key} is no key; write group=option or key=value.")
    if sign and parse(value) is None:
        raise UserError(_unreadable(key, value))


def _setting_of(word: str) -> str:
    """Return the advice for a word without an equals sign, such as ``dlctus``, ``model`` or ``model:dlctus``."""
    key, colon, value = (part.strip() for part in word.partition(":"))
    if colon and value and is_key(key):
        return f"write {key}={value}"
    groups = [group for group in KEYS if word in group_options(group)]
    if groups:
        return f"write {' or '.join(f'{group}={word}' for group in groups)}"
    options = group_options(word)
    return f"write {word}=OPTION, one of {', '.join(options)}" if options else "write group=option or key=value"


def _unreadable(key: str, value: str) -> str:
    """Return the sentence for a value that Hydra's grammar rejects."""
    if value.startswith("="):
        return f"{key}={value} has two equals signs: write {key}={value.lstrip('=')}."
    if value.rstrip("]").endswith(",") or value.lstrip("[").startswith(","):
        plain = re.sub(r",(?=\]*$)|(?<![^\[]),", "", value)
        return f"{key}={value} has a comma too many: write {shlex.quote(f'{key}={plain}')}."
    return (
        f"{key}={value} cannot be read: correct the brackets, quotes or function of the value, or put all of it in "
        f"quotes if it is text, {shell_word(key, value)}."
    )
