"""The identity of a run: a hash of all that can change its result, so that finished work is never repeated.

It names options and numbers (`supersampling.runs.options`), never class paths: moving code changes no identity. Runs of
the first scheme hashed class paths; `Identity.former` is what theirs would be, so that they are still found.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig, OmegaConf

from supersampling.runs.keys import Effect, is_shown, select
from supersampling.runs.options import FORMER, TARGET, described

SCHEME = "2"


@dataclass(frozen=True)
class Identity:
    """An identity of today's scheme, 16 hex digits, and what the first scheme called the same work."""

    key: str
    former: str


def identity(
    cfg: DictConfig, fingerprints: Mapping[str, str], learned: bool, *, weights_only: bool = False
) -> Identity:
    """Return the identity of a configuration on data with these fingerprints, by split.

    Args:
        learned: whether the method is trained.
        weights_only: leave out how the weights are scored, so that two protocols share a training.
    """
    resolved: Any = OmegaConf.to_container(cfg, resolve=True)
    effects = {Effect.WEIGHTS} if weights_only else {Effect.WEIGHTS, Effect.SCORES}
    selected = select(resolved, effects, learned)
    data = dict(fingerprints)
    return Identity(
        digest({"scheme": SCHEME, "config": described(selected), "data": data}),
        digest({"config": with_former_paths(selected), "data": data}),
    )


def digest(content: Any) -> str:
    """Return 16 hex digits of a value's JSON."""
    return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()[:16]


def with_former_paths(config: Any) -> Any:
    """Return a configuration with the class paths that the first scheme's runs have."""
    if isinstance(config, Mapping):
        content = {key: with_former_paths(value) for key, value in config.items()}
        if TARGET in content:
            content[TARGET] = {path: old for old, path in FORMER.items()}.get(content[TARGET], content[TARGET])
        return content
    return [with_former_paths(value) for value in config] if isinstance(config, list) else config


def flat_parameters(cfg: DictConfig, choices: Mapping[str, str], learned: bool) -> dict[str, Any]:
    """Return parameters as MLflow's compare view shows them: a name for each selected option, a value for each number.

    ``model=dlctus``, ``model.reproject=bicubic9``, ``loss.theta=0.1``, ``task.scale=4``, ``budget.steps=60``,
    ``seed=0`` ...
    """
    resolved: Any = OmegaConf.to_container(cfg, resolve=True)
    flat: dict[str, Any] = {}

    def walk(prefix: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for key, inner in value.items():
                if not str(key).startswith("_"):
                    walk(f"{prefix}.{key}" if prefix else str(key), inner)
        elif value is not None:
            flat[prefix] = ",".join(map(str, value)) if isinstance(value, list) else value

    walk("", {str(k): v for k, v in resolved.items() if is_shown(str(k), learned)})
    for group, choice in choices.items():
        if is_shown(group, learned) and choice not in (None, "default"):
            flat[group.replace("/", ".")] = choice
    scenes = resolved["scene"]
    flat["data.scenes"] = scenes if isinstance(scenes, str) else ",".join(scenes)
    return {k: v for k, v in flat.items() if k not in ("model.scale", "data.folder")}
