"""Names of methods: the model, and the stages that differ from the published ones."""

from collections.abc import Mapping
from typing import Any

from supersampling.models.base import Upsampler


def is_learned(model: Upsampler) -> bool:
    """Whether there is anything to train."""
    return any(p.requires_grad for p in model.parameters())


# The stages that a method is published with; a run that swaps one says so in its name.
_PUBLISHED = {
    "dlctus": {"reproject": "bicubic9", "dilate": "none", "pad": "jitter_aligned", "accumulate": "buffer"},
    "tus": {"reproject": "bicubic9", "dilate": "none", "pad": "jitter_aligned", "rectify": "clamp_rgb"},
    "nsrr": {
        "extract": "learned", "upsample": "zero", "warp_at": "target", "reweight": "learned", "colour_space": "ycbcr",
        "demodulate": "display", "guides": "none", "base": "none",
    },
    "nsrd": {
        "demodulate": "lighting", "motion_mask": "dual", "recur": "convlstm", "locate": "none", "base": "none",
    },
    "enss": {
        "flow": "motion_vectors", "history": "blended", "kernel_prediction": "both", "motion_grid": "block",
    },
}  # fmt: skip


def method_name(choices: Mapping[str, Any]) -> str:
    """``dlctus``, or ``dlctus reproject=bilinear`` when a stage differs from the published one."""
    model = choices["model"]
    stages = _PUBLISHED.get(str(model).partition("_")[0], {})  # a size or a faster form has the same stages
    swapped = [f"{s}={choices[f'model/{s}']}" for s in stages if choices.get(f"model/{s}", stages[s]) != stages[s]]
    return " ".join([model, *swapped])
