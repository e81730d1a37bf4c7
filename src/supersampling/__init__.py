"""Neural supersampling: train methods, switch their parts on and off, compare and trust them.

The names in ``__all__`` are the public face; `supersampling.api` is loaded when one of them is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = [
    "BUFFERS",
    "Clip",
    "Estimate",
    "Frame",
    "Result",
    "Upsampler",
    "UserError",
    "WarpCheck",
    "compose_model",
    "disoccluded",
    "finished_runs",
    "frame_scores",
    "gradient_energy",
    "load_model",
    "paired_difference",
    "render_data",
    "score",
    "upsample",
    "warp_images",
]

if TYPE_CHECKING:
    from supersampling.api import *


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"The package supersampling has no public name {name}: use one of {', '.join(__all__)}.")
    return getattr(import_module("supersampling.api"), name)
