"""The command ``count``: parameters and multiply-accumulates of a configuration, module by module."""

from collections.abc import Sequence

import pandas as pd
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling import settings
from supersampling.config import typed_overrides
from supersampling.models.base import Upsampler
from supersampling.models.count import Row, count_modules

COUNTED = (
    "MACs are those of convolutions and matrix products, for one frame once the state has reached its full size. Not "
    "counted: "
    "biases, activations, warps and other interpolation, and other element-wise work."
)


def count(cfg: DictConfig) -> None:
    """Print the table of the configured method.

    Raises:
        UserError: an invalid size, depth or device.
    """
    width, height = settings.size(cfg.size, "size")
    model: Upsampler = instantiate(cfg.model)
    rows = count_modules(model, width, height, settings.whole(cfg, "depth"), cfg.device)
    title = " ".join(typed_overrides()) or type(model).__name__
    print(f"{title}: {width}x{height} to {width * model.scale}x{height * model.scale}")
    print(table(rows).to_string(index=False))
    print(COUNTED)


def table(rows: Sequence[Row]) -> pd.DataFrame:
    """Return rows as they are printed: parameters in thousands (K), MACs in thousand millions (G)."""
    return pd.DataFrame(
        {
            "module": [row.module for row in rows],
            "class": [row.kind for row in rows],
            "parameters": [f"{row.parameters:,}" for row in rows],
            "K": [f"{row.parameters / 1e3:.2f}" for row in rows],
            "GMAC": [f"{row.macs / 1e9:.4f}" for row in rows],
        }
    )
