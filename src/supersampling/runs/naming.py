"""Names of methods: the model, and the stages that differ from the published ones."""

from collections.abc import Mapping
from typing import Any

from supersampling.config import published_stages
from supersampling.models.base import Upsampler


def is_learned(model: Upsampler) -> bool:
    """Return whether there is anything to train."""
    return any(p.requires_grad for p in model.parameters())


def method_name(choices: Mapping[str, Any]) -> str:
    """Return ``dlctus``, or ``dlctus reproject=bilinear`` if a stage differs from the published one."""
    model = str(choices["model"])
    swapped = [
        f"{slot}={choices[group]}"
        for slot, option in published_stages(model).items()
        if choices.get(group := f"model/{slot}", option) != option
    ]
    return " ".join([model, *swapped])
