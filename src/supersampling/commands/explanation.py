"""Errors of Hydra while it reads or composes a command line, each in one sentence."""

import difflib
import re
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path

from hydra.errors import MissingConfigException
from omegaconf import DictConfig, ListConfig, OmegaConf

from supersampling.commands.quoting import shell_word
from supersampling.config import composed, group_options, key_of, option_file, published_stages, read_option
from supersampling.errors import UserError, chain
from supersampling.resources import PACKAGE

SENTENCES = (
    (r"Sweep parameters '(?P<word>.*)' requires", "{word} runs several jobs: add -m."),
    (r"An item is already at '(?P<key>.*)'", "{key} exists: write {key}=VALUE, without +."),
    (r"Multiple values for (?P<key>.*)\. To", "{key} has an option: write {key}=OPTION, without +."),
    (r"'(?P<key>.*)' does not exist", "~{key} deletes a setting that does not exist: leave it out."),
    (r"The value of '(?P<key>.*)' is", "~{key}=VALUE deletes a setting of this value only: write ~{key}."),
    (r"Error resolving interpolation '\$\{(?P<key>[\w/]+)\}'", "{key} has no option: write {key}=OPTION."),
    (r"does not support sweep type", "interval() needs another sweeper than Hydra's: write the values, or range()."),
)
"""What Hydra says of a mistake, and the sentence for it."""


def raised_by_libraries(error: BaseException) -> bool:
    """Return whether no line of this package raised an error or what led to it."""
    frames = [list(traceback.walk_tb(cause.__traceback__)) for cause in chain(error)]
    files = [Path(trace[-1][0].f_code.co_filename) for trace in frames if trace]
    return not any(file.is_relative_to(PACKAGE) for file in files)


def reason_of(error: BaseException) -> str:
    """Return the reason of an error in one line, without the remark that an override could not be read or merged."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    if lines and lines[0].startswith("Error merging override") and error.__cause__ is not None:
        return f"{lines[0].removeprefix('Error merging override ')}: {reason_of(error.__cause__)}"
    if len(lines) > 1 and lines[0].startswith("Error parsing override"):
        lines = lines[1:]
    return lines[0].rstrip(".:") if lines else type(error).__name__


def explanation(command: str, arguments: Sequence[str], error: Exception) -> str:
    """Return one sentence for an error of Hydra's while it reads or composes a command line."""
    if isinstance(error, MissingConfigException) and error.missing_cfg_file:
        return _missing_file(str(error.missing_cfg_file), error.options or ())
    text = reason_of(error)
    if isinstance(error, OSError):
        return f"A folder cannot be used ({text}): set paths.root, hydra.run.dir or hydra.sweep.dir to another one."
    several = re.search(r"Ambiguous value for argument '(.*?)=(.*)'", text)
    if several:
        return _several_values(several[1], several[2])
    for pattern, sentence in SENTENCES:
        match = re.search(pattern, text)
        if match:
            return sentence.format(**match.groupdict())
    match = re.search(r"Could not override '([^']+)'", text)
    if match is None:
        return f"The command line cannot be composed ({text}): see python {command}.py --help."
    key = match[1].partition("@")[0]
    experiment = re.match(r"In 'experiment/([^']+)'", text)
    if experiment and key.startswith("model/"):
        return _slot_of_experiment(arguments, experiment[1], key)
    if key.startswith("model/"):
        return _missing_slot(command, arguments, key.removeprefix("model/"))
    return _missing_setting(command, arguments, key)


def _several_values(key: str, value: str) -> str:
    return (
        f"{key}={value} holds several values: add -m to run a job for each, write {key}=[{value}] for a list, or "
        f"{shell_word(key, value)} for text with a comma."
    )


def _missing_file(name: str, known: Sequence[str]) -> str:
    """Return the options of the group of a missing configuration file."""
    group, _, option = name.rpartition("/")
    if not group:
        return f"There is no configuration {option}.yaml: --config-name takes a file of conf/ or of --config-dir."
    if group == "recipe":
        return (
            f"Model {option} has no recipe: write conf/recipe/{option}.yaml with the loss, task and window choice of "
            "its training, or set recipe=none."
        )
    options = ", ".join(group_options(group) or known)
    return f"Unknown option {group}={option}: {f'use {options}' if options else f'there is no group {group}'}."


def _slot_of_experiment(arguments: Sequence[str], experiment: str, slot: str) -> str:
    """Return what to write in place of an experiment that sets a slot of its own model, which another word replaces."""
    listed = " ".join(word for word in arguments if key_of(word) == "experiment")
    published = [f"{name}_published" for name in re.findall(r"[\w/]+", listed)]
    forms = [name for name in published if option_file("experiment", name).is_file()]
    advice = f"write experiment={forms[0]}" if forms else "leave the experiment or the other model out"
    return f"experiment={experiment} sets {slot}, which the other model of the command line does not have: {advice}."


def owners(group: str, name: str) -> list[str]:
    """Return the options of a group that have a setting."""
    return [option for option in group_options(group) if name in _settings(group, option)]


def _missing_slot(command: str, arguments: Sequence[str], slot: str) -> str:
    """Return which slots the model has, and which models have the slot."""
    model = _selected(command, arguments, "model")
    if model not in group_options("model"):
        return f"{command}.py has no setting model/{slot}, as it has no model: see python {command}.py --help."
    owners = [name for name in group_options("model") if slot in published_stages(name)]
    slots = ", ".join(published_stages(model)) or "none"
    advice = f"set model={' or model='.join(owners)}, or one" if owners else "use one"
    return f"Model {model} has no slot {slot}: {advice} of its own slots ({slots})."


def _missing_setting(command: str, arguments: Sequence[str], key: str) -> str:
    """Return the settings beside an unknown one, and the options of its group that do have it."""
    group, _, name = key.rpartition(".")
    if not group or not group_options(group) or group.startswith("hydra"):
        return _missing_key(command, arguments, key)
    option = _selected(command, arguments, group)
    having = owners(group, name)
    known = ", ".join(_settings(group, option)) or "none"
    advice = f"set {group}={' or '.join(having)}, or one" if having else "use one"
    return f"{group}={option} has no setting {name}: {advice} of its own settings ({known})."


def _missing_key(command: str, arguments: Sequence[str], key: str) -> str:
    """Return the settings beside an unknown one, or those with a similar name."""
    if key.split(".")[0] == "hydra":
        return f"Hydra has no setting {key}: see python {command}.py --cfg hydra."
    cfg = _composed(command, arguments, key.split(".")[0])
    if group_options(key) and key in cfg:
        return f"{key} is a group without this setting: write {key}=OPTION, one of {', '.join(group_options(key))}."
    parent = key.rpartition(".")[0]
    node = OmegaConf.select(cfg, parent) if parent else None
    if isinstance(node, DictConfig):
        return f"{command}.py has no setting {key}: use one of the settings of {parent} ({', '.join(map(str, node))})."
    if isinstance(node, ListConfig):
        return f"{parent} is a list: set all of it, {parent}=[VALUE,VALUE]."
    similar = difflib.get_close_matches(key.lower(), list(_keys(cfg)), 1)
    if similar:
        return f"{command}.py has no setting {key}: write {similar[0]}, or see python {command}.py --help."
    return f"{command}.py has no setting {key}: see python {command}.py --help for its groups and settings."


def _keys(cfg: DictConfig, prefix: str = "") -> Iterator[str]:
    """Yield every key of a configuration, such as ``loss`` and ``loss.theta``."""
    for name, value in cfg.items_ex(resolve=False):
        yield prefix + str(name)
        if isinstance(value, DictConfig) and not value._is_interpolation() and not value._is_none():
            yield from _keys(value, f"{prefix}{name!s}.")


def _composed(command: str, arguments: Sequence[str], key: str) -> DictConfig:
    """Return the configuration of the words that do not set this top-level key; the default one if that fails too."""
    words = [word for word in _simple(arguments) if key_of(word).split(".")[0] != key]
    try:
        return composed(command, words).cfg
    except UserError:
        return composed(command, []).cfg


def _simple(arguments: Sequence[str]) -> list[str]:
    """Return the words that set one value."""
    words = [word for word in arguments if "=" in word and not word.startswith("-")]
    return [word for word in words if "," not in word or "[" in word]


def _selected(command: str, arguments: Sequence[str], group: str) -> str:
    """Return the option of a group that the rest of the command line selects."""
    parts = (f"{group}.", f"{group}/")
    words = [word for word in arguments if not key_of(word).startswith(parts)]
    words = [word.partition(",")[0] if key_of(word) == group else word for word in words]  # the first of a sweep
    try:
        return str(composed(command, _simple(words)).choices.get(group, "default"))
    except UserError:
        return "default"


def _settings(group: str, option: str) -> list[str]:
    """Return the settings that an option's file sets, with those of the files in its group that it is based on."""
    path = option_file(group, option)
    if not path.is_file():
        return []
    content, bases = read_option(path)
    inherited = [name for base in bases for name in _settings(group, base.stem)]
    names = [str(name) for name in content if name != "defaults" and not str(name).startswith("_")]
    return list(dict.fromkeys([*inherited, *names]))
