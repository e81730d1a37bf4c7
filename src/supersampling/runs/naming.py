"""Names of methods: the model, and the stages that differ from the published ones."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import yaml

from supersampling.models.base import Upsampler
from supersampling.resources import resources


def is_learned(model: Upsampler) -> bool:
    """Return whether there is anything to train."""
    return any(p.requires_grad for p in model.parameters())


@lru_cache
def published_stages(model: str) -> Mapping[str, str]:
    """Return the option of each slot that a model is published with: the defaults of ``conf/model/<model>.yaml``."""
    path = resources() / "conf" / "model" / f"{model}.yaml"
    content: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
    stages: dict[str, str] = {}
    for entry in content.get("defaults", []):
        if isinstance(entry, str) and entry != "_self_":
            stages |= published_stages(entry)
        elif isinstance(entry, dict):
            stages |= {str(slot).removeprefix("override ").strip("/"): str(option) for slot, option in entry.items()}
    return stages


def method_name(choices: Mapping[str, Any]) -> str:
    """Return ``dlctus``, or ``dlctus reproject=bilinear`` if a stage differs from the published one."""
    model = str(choices["model"])
    swapped = [
        f"{slot}={choices[group]}"
        for slot, option in published_stages(model).items()
        if choices.get(group := f"model/{slot}", option) != option
    ]
    return " ".join([model, *swapped])
