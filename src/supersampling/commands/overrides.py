"""Wrong switches on a command line, each answered by one sentence before anything is rendered."""

import re
from collections.abc import Iterator, Sequence

from hydra.errors import ConfigCompositionException, MissingConfigException, OverrideParseException

from supersampling.config import composed, group_options, key_of, published_stages, read_option
from supersampling.errors import UserError
from supersampling.resources import resources

MOVED = {
    "logger.tracking_uri": "tracking_uri",
    "logger.experiment": "experiment_name",
    "pick.ms": "pick.py ms",
    "pick.db": "pick.py db",
    "import": "import_capture.py layout",
    "export": "export_capture.py layout",
}
"""Keys of earlier versions, and what to write today."""


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
    for word in _overrides(arguments):
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
        if options and "." not in key and not _adds_options(arguments):
            for option in _simple_values(value):
                if option not in options:
                    raise UserError(f"Unknown option {key}={option}: use {', '.join(options)}.")


def _adds_options(arguments: Sequence[str]) -> bool:
    """Return whether the command line names folders with options of the user's own: then only Hydra knows them all."""
    return any(word.startswith(("--config-dir", "-cd", "hydra.searchpath=")) for word in arguments)


def _overrides(arguments: Sequence[str]) -> Iterator[str]:
    return (word for word in arguments if "=" in word and not word.startswith("-"))


def _simple_values(value: str) -> list[str]:
    """Return the options of ``a,b``, none of what needs Hydra's own grammar."""
    return value.split(",") if re.fullmatch(r"[\w,]+", value) and value != "null" else []


def explanation(command: str, arguments: Sequence[str], error: Exception) -> str | None:
    """Return one sentence for an error of Hydra's composition, None if the mistake is not the user's."""
    text = str(error)
    if isinstance(error, OverrideParseException):
        return (
            f"{error.override} cannot be read as key=value ({text.splitlines()[0]}): put special characters in quotes."
        )
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        group, _, option = str(error.missing_cfg_file).rpartition("/")
        return f"Unknown option {group}={option}: use {', '.join(group_options(group) or error.options or ())}."
    match = re.search(r"Could not override '([^']+)'", text)
    if not isinstance(error, ConfigCompositionException) or match is None:
        return None
    key = match[1].partition("@")[0]
    if key.startswith("model/"):
        return _missing_slot(command, arguments, key.removeprefix("model/"))
    return _missing_setting(command, arguments, key)


def _missing_slot(command: str, arguments: Sequence[str], slot: str) -> str:
    """Return which slots the model has, and which models have the slot."""
    model = _selected(command, arguments, "model")
    owners = [name for name in group_options("model") if slot in published_stages(name)]
    slots = ", ".join(published_stages(model)) or "none"
    advice = f"set model={' or model='.join(owners)}, or one" if owners else "use one"
    return f"Model {model} has no slot {slot}: {advice} of its own slots ({slots})."


def _missing_setting(command: str, arguments: Sequence[str], key: str) -> str:
    """Return the settings beside an unknown one, and the options of its group that do have it."""
    group, _, name = key.rpartition(".")
    if not group:
        return f"{command}.py has no setting {key}: see python {command}.py --help for its groups and settings."
    option = _selected(command, arguments, group)
    owners = [o for o in group_options(group) if name in _settings(group, o)]
    known = ", ".join(_settings(group, option)) or "none"
    advice = f"set {group}={' or '.join(owners)}, or one" if owners else "use one"
    return f"{group}={option} has no setting {name}: {advice} of its own settings ({known})."


def _selected(command: str, arguments: Sequence[str], group: str) -> str:
    """Return the option of a group that the rest of the command line selects."""
    parts = (f"{group}.", f"{group}/")
    words = [word for word in _overrides(arguments) if not key_of(word).startswith(parts)]
    words = [word.partition(",")[0] if key_of(word) == group else word for word in words]  # the first of a sweep
    words = [word for word in words if "," not in word or "[" in word]
    try:
        return str(composed(command, words).choices.get(group, "default"))
    except UserError:
        return "default"


def _settings(group: str, option: str) -> list[str]:
    """Return the settings that an option's file sets, with those of the files in its group that it is based on."""
    path = resources() / "conf" / group / f"{option}.yaml"
    if not path.is_file():
        return []
    content, bases = read_option(path)
    inherited = [name for base in bases for name in _settings(group, base.stem)]
    names = [str(name) for name in content if name != "defaults" and not str(name).startswith("_")]
    return list(dict.fromkeys([*inherited, *names]))
