"""Functions that configuration files call."""

import math
import os

from omegaconf import OmegaConf

from supersampling.config import group_options, published_stages
from supersampling.resources import output_root, resources


def _installed_scenes() -> list[str]:
    from supersampling.scenes.load import installed_scenes

    return installed_scenes()


def _built_in_scenes() -> list[str]:
    from supersampling.scenes.built_in import BUILT_IN

    return list(BUILT_IN)


def _model_slots() -> str:
    """Return a line per model with its slots, for ``--help``."""
    slots = {model: ", ".join(published_stages(model)) for model in group_options("model")}
    return "\n".join(f"{model}: {names}" for model, names in slots.items() if names)


def _tracking_uri(path: str) -> str:
    from supersampling.runs.location import configured_uri

    return configured_uri(path)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def register() -> None:
    """Register ``${installed_scenes:}``, ``${built_in_scenes:}``, ``${model_slots:}``, ``${cores:}``,
    ``${product:a,b}``, ``${tracking_uri:path}``, ``${resources:}`` and ``${output_root:}``.
    """
    OmegaConf.register_new_resolver("installed_scenes", _installed_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("built_in_scenes", _built_in_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("model_slots", _model_slots, replace=True)
    OmegaConf.register_new_resolver("cores", _cores, replace=True)
    OmegaConf.register_new_resolver("product", lambda *values: math.prod(int(v) for v in values), replace=True)
    OmegaConf.register_new_resolver("tracking_uri", _tracking_uri, replace=True)
    OmegaConf.register_new_resolver("resources", lambda: str(resources()), replace=True)
    OmegaConf.register_new_resolver("output_root", lambda: str(output_root()), replace=True)
