"""A run's identity: a hash of all that can change its result, so that finished work is never done twice."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from omegaconf import DictConfig, OmegaConf

# Keys that cannot change a result. What a data set was made from is replaced by the fingerprint of what it holds.
NOT_IDENTITY = (
    "paths", "logger", "data", "scene", "path", "baselines", "fresh", "workers", "trainer.enable_progress_bar",
    "trainer.accelerator", "trainer.devices", "sweeps", "experiment", "debug", "threads", "metrics",
)  # fmt: skip
# Weights do not depend on how they are scored, so that two protocols share a training.
WEIGHTS_ONLY = ("protocol",)


def _without(tree: Mapping[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    kept = {}
    for key, value in tree.items():
        if key in keys:
            continue
        inner = tuple(k.removeprefix(f"{key}.") for k in keys if k.startswith(f"{key}."))
        kept[key] = _without(value, inner) if isinstance(value, Mapping) else value
    return kept


# Nor can these change the result of a classical method, which is not trained.
ONLY_LEARNED = ("loss", "pick", "augment", "optimizer", "budget", "trainer", "seed")


def identity(cfg: DictConfig, fingerprints: Mapping[str, str], learned: bool, without: tuple[str, ...] = ()) -> str:
    """16 hex digits of the resolved configuration, less what cannot change the result and ``without``, and each split's
    fingerprint."""
    resolved: Any = OmegaConf.to_container(cfg, resolve=True)
    left_out = (NOT_IDENTITY if learned else NOT_IDENTITY + ONLY_LEARNED) + without
    content = {"config": _without(resolved, left_out), "data": dict(fingerprints)}
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:16]


# Top-level keys that are not shown as parameters.
_HIDDEN = (
    "paths",
    "logger",
    "baselines",
    "fresh",
    "workers",
    "sweeps",
    "experiment",
    "debug",
    "scene",
    "path",
    "tune",
    "threads",
    "metrics",
)


def flat_parameters(cfg: DictConfig, choices: Mapping[str, str], learned: bool) -> dict[str, Any]:
    """Parameters as the MLflow compare view shows them: a name for each chosen option, a value for each number.

    ``model=dlctus``, ``model.reproject=bicubic9``, ``loss.theta=0.1``, ``task.scale=4``, ``budget.steps=60``, ``seed=0`` ...
    """
    resolved: Any = OmegaConf.to_container(cfg, resolve=True)
    hidden = _HIDDEN if learned else _HIDDEN + ONLY_LEARNED
    flat: dict[str, Any] = {}

    def walk(prefix: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for key, inner in value.items():
                if not str(key).startswith("_"):
                    walk(f"{prefix}.{key}" if prefix else str(key), inner)
        elif value is not None:
            flat[prefix] = ",".join(map(str, value)) if isinstance(value, list) else value

    walk("", {str(k): v for k, v in resolved.items() if k not in hidden})
    for group, choice in choices.items():
        if group.split("/")[0] not in (*hidden, "hydra") and choice not in (None, "default"):
            flat[group.replace("/", ".")] = choice
    scenes = resolved["scene"]
    flat["data.scenes"] = scenes if isinstance(scenes, str) else ",".join(scenes)
    return {k: v for k, v in flat.items() if k not in ("model.scale", "data.folder")}
