"""The command ``count``: parameters and multiply-accumulates of a configuration."""

from collections.abc import Sequence

import pandas as pd
from hydra.core.hydra_config import HydraConfig
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.count import Row, count

COUNTED = (
    "MACs are those of convolutions and matrix products, for one frame once the state has reached its full size. Not counted: "
    "biases, activations, warps and other interpolation, and what else works element by element."
)


def table(rows: Sequence[Row]) -> pd.DataFrame:
    """Rows as they are printed: parameters in thousands (K), MACs in thousand millions (G)."""
    return pd.DataFrame(
        {
            "module": [row.module for row in rows],
            "class": [row.kind for row in rows],
            "parameters": [f"{row.parameters:,}" for row in rows],
            "K": [f"{row.parameters / 1e3:.2f}" for row in rows],
            "GMAC": [f"{row.macs / 1e9:.4f}" for row in rows],
        }
    )


def count_command(cfg: DictConfig) -> None:
    """What ``count.py`` does: print the configured method's table.

    Raises:
        UserError: a size or depth that is not possible.
    """
    size = list(cfg.size)
    if len(size) != 2 or not all(isinstance(n, int) and 1 <= n <= 2**15 for n in size):
        raise UserError(f"size={size} is not possible: use [width,height] of the low-resolution input in pixels.")
    if not isinstance(cfg.depth, int) or cfg.depth < 1:
        raise UserError(f"depth={cfg.depth} is not possible: use a whole number from 1 up.")
    width, height = size
    model: Upsampler = instantiate(cfg.model)
    rows = count(model, width, height, cfg.depth, cfg.device)
    said = " ".join(HydraConfig.get().overrides.task) if HydraConfig.initialized() else ""
    print(f"{said or type(model).__name__}: {width}x{height} to {width * model.scale}x{height * model.scale}")
    print(table(rows).to_string(index=False))
    print(COUNTED)
