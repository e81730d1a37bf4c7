"""Functions that configuration files call."""

import math
import os

from omegaconf import OmegaConf

from supersampling.resources import output_root, resources


def _installed_scenes() -> list[str]:
    from supersampling.scenes.load import installed_scenes

    return installed_scenes()


def _built_in_scenes() -> list[str]:
    from supersampling.scenes.built_in import BUILT_IN

    return list(BUILT_IN)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def register() -> None:
    """Register ``${installed_scenes:}``, ``${built_in_scenes:}``, ``${cores:}``, ``${product:a,b}``, ``${resources:}``,
    ``${output_root:}``."""
    OmegaConf.register_new_resolver("installed_scenes", _installed_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("built_in_scenes", _built_in_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("cores", _cores, replace=True)
    OmegaConf.register_new_resolver("product", lambda *values: math.prod(int(v) for v in values), replace=True)
    OmegaConf.register_new_resolver("resources", lambda: str(resources()), replace=True)
    OmegaConf.register_new_resolver("output_root", lambda: str(output_root()), replace=True)
