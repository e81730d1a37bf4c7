"""Functions that configuration files call."""

import math
import os
from typing import Any

from hydra.core.hydra_config import HydraConfig
from omegaconf import ListConfig, OmegaConf
from omegaconf.base import Container

from supersampling.config import group_options, option_file, published_stages, read_option, recipe_of
from supersampling.errors import UserError
from supersampling.resources import output_root, resources


def _installed_scenes() -> ListConfig:
    from supersampling.scenes.load import installed_scenes

    return ListConfig(installed_scenes())


def _built_in_scenes() -> ListConfig:
    from supersampling.scenes.built_in import BUILT_IN

    return ListConfig(list(BUILT_IN))


def _model_slots() -> str:
    """Return a line per model with its slots, for ``--help``."""
    slots = {model: ", ".join(published_stages(model)) for model in group_options("model")}
    return "\n".join(f"{model}: {names}" for model, names in slots.items() if names)


def _recipes() -> str:
    """Return a line per model with what its recipe selects, for ``--help``."""
    return "\n".join(f"{model}: {_recipe_line(model)}" for model in group_options("model"))


def _recipe_line(model: str) -> str:
    _, bases = read_option(option_file("recipe", model))
    if [base.stem for base in bases] == ["none"]:
        return "none, it is not trained"
    recipe = recipe_of(model)
    jitter = read_option(option_file("task", recipe["task"]))[0]["jitter"]
    return " ".join(f"{group}={option}" for group, option in recipe.items()) + f" (task.jitter={jitter})"


def _tracking_uri(path: str) -> str:
    from supersampling.runs.location import configured_uri

    return configured_uri(path)


def _product(*values: object) -> int:
    if not all(isinstance(value, int) and not isinstance(value, bool) for value in values):
        raise UserError(f"{' times '.join(map(str, values))} is no product: use whole numbers for these settings.")
    return math.prod(values)  # type: ignore[arg-type]


def _project_root(_root_: Container) -> str:
    """Return ``paths.root``, also for ``--cfg hydra``, which shows only Hydra's part of the configuration."""
    local = OmegaConf.select(_root_, "paths.root")
    if local is not None:
        return str(local)
    hydra: Any = HydraConfig.get()
    return str(OmegaConf.select(hydra, "..paths.root"))


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def register() -> None:
    """Register ``${installed_scenes:}``, ``${built_in_scenes:}``, ``${model_slots:}``, ``${recipes:}``,
    ``${cores:}``, ``${product:a,b}``, ``${tracking_uri:path}``, ``${resources:}``, ``${output_root:}`` and
    ``${project_root:}``.
    """
    OmegaConf.register_new_resolver("installed_scenes", _installed_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("built_in_scenes", _built_in_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("model_slots", _model_slots, replace=True)
    OmegaConf.register_new_resolver("recipes", _recipes, replace=True)
    OmegaConf.register_new_resolver("cores", _cores, replace=True)
    OmegaConf.register_new_resolver("product", _product, replace=True)
    OmegaConf.register_new_resolver("tracking_uri", _tracking_uri, replace=True)
    OmegaConf.register_new_resolver("resources", lambda: str(resources()), replace=True)
    OmegaConf.register_new_resolver("output_root", lambda: str(output_root()), replace=True)
    OmegaConf.register_new_resolver("project_root", _project_root, replace=True)
