"""The models of a command: from the configuration with random weights, or one trained model."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling import settings
from supersampling.config import composed, group_options
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.runs.method import method_of


@dataclass(frozen=True)
class Source:
    """A model by name, with the scale of the configuration or of its training.

    ``load(scale)`` returns the model at a scale, or None if the model was trained for another scale.
    """

    name: str
    scale: int
    load: Callable[[int], Upsampler | None]

    def model(self) -> Upsampler:
        """Return the model at its own scale."""
        model = self.load(self.scale)
        if model is None:
            raise ValueError(f"{self.name} has no model at its own scale {self.scale}.")
        return model


def select_models(cfg: DictConfig, full: bool) -> list[str]:
    """Return the models of the key ``models``, or if it is null, all of ``conf/model`` or the list ``quick``."""
    if cfg.models is not None:
        return [str(name) for name in cfg.models]
    return group_options("model") if full else [str(name) for name in cfg.quick]


def load_sources(cfg: DictConfig, full: bool, device: str) -> list[Source]:
    """Return the trained model of ``run`` or ``checkpoint``, or the models of `select_models` with random weights.

    A model is the name of a file in ``conf/model``, with overrides of its own after a space.

    Raises:
        UserError: the model, run or checkpoint does not exist, or has another architecture than the command line says.
    """
    if settings.exclusive(cfg, "run", "checkpoint"):
        method = method_of(cfg)
        trained = method.model.to(device).eval()
        name = method.name or "trained"
        return [Source(name, trained.scale, lambda scale: trained if scale == trained.scale else None)]
    scale = int(cfg.task.scale)
    sources = [
        Source(name, scale, lru_cache(2)(_loader(name, int(cfg.seed), device))) for name in select_models(cfg, full)
    ]
    for source in sources:
        source.load(scale)  # Unknown names are reported before anything is computed.
    return sources


def _loader(name: str, seed: int, device: str) -> Callable[[int], Upsampler | None]:
    def load(scale: int) -> Upsampler | None:
        option, *overrides = name.split()
        cfg = composed("stress", [f"model={option}", *overrides, f"task.scale={scale}"]).cfg
        torch.manual_seed(seed)
        try:
            model: Upsampler = instantiate(cfg.model)
        except InstantiationException as error:
            if isinstance(error.__cause__, UserError):
                raise error.__cause__ from error
            raise
        return model.to(device).eval()

    return load
