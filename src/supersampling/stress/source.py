"""The models that are tried: of the configuration with random weights, or one that was trained."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig

from supersampling.config import composed
from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.runs.method import method_of

SCALES = range(1, 9)


@dataclass(frozen=True)
class Source:
    """A model by name. ``make(scale)`` gives it at a scale, or None where it was trained for another."""

    name: str
    scale: int
    make: Callable[[int], Upsampler | None]


def sources(cfg: DictConfig, models: tuple[str, ...], device: str) -> list[Source]:
    """What ``run`` or ``checkpoint`` name, else every one of ``models``: a file in ``conf/model``, and overrides after it.

    Raises:
        UserError: no such model, run or checkpoint; one of another architecture than the command line says.
    """
    if cfg.run and cfg.checkpoint:
        raise UserError("run and checkpoint were both given: use one of them.")
    if cfg.run or cfg.checkpoint:
        method = method_of(cfg)
        trained, name = method.model.to(device).eval(), method.name or "trained"
        return [Source(name, trained.scale, lambda scale: trained if scale == trained.scale else None)]
    scale = int(cfg.task.scale)
    made = [Source(name, scale, lru_cache(2)(_maker(name, int(cfg.seed), device))) for name in models]
    for source in made:
        source.make(scale)  # a name that is none is told before anything is computed
    return made


def _maker(name: str, seed: int, device: str) -> Callable[[int], Upsampler | None]:
    def make(scale: int) -> Upsampler | None:
        model, *overrides = str(name).split()
        cfg = composed("stress", [f"model={model}", *overrides, f"task.scale={scale}"]).cfg
        torch.manual_seed(seed)
        try:
            made: Upsampler = instantiate(cfg.model)
        except InstantiationException as error:
            if isinstance(error.__cause__, UserError):
                raise error.__cause__ from error
            raise
        return made.to(device).eval()

    return make
