"""Configurations composed in code, by the one function that every command uses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml
from hydra import compose, initialize_config_dir
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import ConfigCompositionException, HydraException
from omegaconf import DictConfig, open_dict
from omegaconf.errors import OmegaConfBaseException

from supersampling.errors import UserError
from supersampling.resources import resources

VERSION_BASE = "1.3"


@dataclass(frozen=True)
class ComposedConfig:
    """A configuration, and the selected option of each group."""

    cfg: DictConfig
    choices: dict[str, str]


def composed(name: str, overrides: Sequence[str]) -> ComposedConfig:
    """Compose a command's configuration, inside of a Hydra application or without one.

    Raises:
        UserError: an override that this configuration does not have.
    """
    try:
        if GlobalHydra.instance().is_initialized():
            cfg = compose(name, list(overrides), return_hydra_config=True)
        else:
            with initialize_config_dir(str(resources() / "conf"), version_base=VERSION_BASE):
                cfg = compose(name, list(overrides), return_hydra_config=True)
    except (ConfigCompositionException, HydraException, OmegaConfBaseException) as error:
        reason = str(error).splitlines()[0].rstrip(".:")
        raise UserError(
            f"{' '.join(overrides)} cannot be composed ({reason}): see python {name}.py --help for the groups and "
            "settings."
        ) from error
    choices = dict(cfg.hydra.runtime.choices)
    with open_dict(cfg):
        del cfg["hydra"]
    return ComposedConfig(cfg, choices)


def group_options(group: str) -> list[str]:
    """Return the options of a group such as ``model`` or ``model/reproject``."""
    folder: Path = resources() / "conf" / group
    return sorted(path.stem for path in folder.glob("*.yaml"))


def option_file(group: str, option: str) -> Path:
    """Return the path of an option's file, whether it exists or not."""
    return resources() / "conf" / group / f"{option}.yaml"


def read_option(path: Path) -> tuple[dict[str, Any], list[Path]]:
    """Return the content of an option's file, and the files of its own group that it is based on."""
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict):
        return {}, []
    names = [entry for entry in content.get("defaults", []) if isinstance(entry, str) and entry.isidentifier()]
    files = [path.with_name(f"{name}.yaml") for name in names]
    return content, [file for file in files if file.exists()]


@lru_cache
def published_stages(model: str) -> Mapping[str, str]:
    """Return the option of each slot that a model is published with: the defaults of ``conf/model/<model>.yaml``."""
    content, bases = read_option(option_file("model", model))
    stages = {slot: option for base in bases for slot, option in published_stages(base.stem).items()}
    for entry in content.get("defaults", []):
        if isinstance(entry, dict):
            stages |= {str(slot).removeprefix("override ").strip("/"): str(option) for slot, option in entry.items()}
    return stages


@lru_cache
def recipe_of(model: str) -> Mapping[str, str]:
    """Return the option of each group that a model brings to its training: the defaults of
    ``conf/recipe/<model>.yaml``."""
    content, bases = read_option(option_file("recipe", model))
    recipe = {group: option for base in bases for group, option in recipe_of(base.stem).items()}
    for entry in content.get("defaults", []):
        if isinstance(entry, dict):
            recipe |= {str(group).strip("/"): str(option) for group, option in entry.items()}
    return recipe


def typed_overrides() -> list[str]:
    """Return the overrides of the command line, none outside of a Hydra application."""
    return overrides_of(HydraConfig.get()) if HydraConfig.initialized() else []


def overrides_of(hydra: Any) -> list[str]:
    """Return the overrides of a command line from Hydra's part of its configuration, with ``${key}`` as typed."""
    return [str(word) for word in hydra.overrides.task._iter_ex(resolve=False)]


def key_of(override: str) -> str:
    """Return the key or group that an override sets: ``model/reproject`` of ``+model/reproject@x=bilinear``."""
    return override.lstrip("+~").partition("=")[0].partition("@")[0]


def choices() -> dict[str, Any]:
    """Return the selected option of each group of the running command."""
    return dict(HydraConfig.get().runtime.choices)
