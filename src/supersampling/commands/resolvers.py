"""The few functions that configuration files call."""

import math
import os

from omegaconf import OmegaConf


def _installed_scenes() -> list[str]:
    from supersampling.scenes.load import installed_scenes

    return installed_scenes()


def _built_in_scenes() -> list[str]:
    from supersampling.scenes.built_in import BUILT_IN

    return list(BUILT_IN)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def register() -> None:
    """Make ``${installed_scenes:}``, ``${built_in_scenes:}``, ``${cores:}`` and ``${product:a,b}`` known to OmegaConf."""
    OmegaConf.register_new_resolver("installed_scenes", _installed_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("built_in_scenes", _built_in_scenes, use_cache=True, replace=True)
    OmegaConf.register_new_resolver("cores", _cores, replace=True)
    OmegaConf.register_new_resolver("product", lambda *values: math.prod(int(v) for v in values), replace=True)
