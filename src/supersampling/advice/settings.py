"""The settings of ``advise.py``, checked once."""

from dataclasses import dataclass
from pathlib import Path

from omegaconf import DictConfig, OmegaConf

from supersampling import settings
from supersampling.advice.cost import Size
from supersampling.advice.space import Space, read_space
from supersampling.advice.trainings import Rungs
from supersampling.config import group_options
from supersampling.errors import UserError

SEARCHES = ("halving", "optuna")
LARGEST_MARGIN = 100.0  # dB


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The settings of a search; ``steps`` is None without a limit."""

    space: Space
    margin: float
    rungs: Rungs
    steps: int | None
    search: str
    trials: int
    walk: int
    prune: bool
    size: Size
    frames: int
    render_costs: bool
    out: Path


def read_settings(cfg: DictConfig) -> Settings:
    """Return the settings of a configuration.

    Raises:
        UserError: a setting is invalid.
    """
    if settings.positive(cfg, "margin") >= LARGEST_MARGIN:
        raise UserError(f"Invalid margin={cfg.margin}: use a number of dB below {LARGEST_MARGIN:g}.")
    if OmegaConf.select(cfg, "among") is None:
        raise UserError(
            f"This model has no space of its own: set among to {', '.join(group_options('among'))}, or write a space "
            "into conf/among/."
        )
    return Settings(
        space=read_space(OmegaConf.to_container(cfg.among, resolve=True)),
        margin=float(cfg.margin),
        rungs=_read_rungs(cfg),
        steps=None if cfg.steps is None else settings.whole(cfg, "steps"),
        search=settings.choice(cfg, "search", SEARCHES),
        trials=settings.whole(cfg, "trials"),
        walk=settings.whole(cfg, "walk"),
        prune=bool(cfg.prune),
        size=Size(*settings.size(cfg.size, "size")),
        frames=settings.whole(cfg, "frames"),
        render_costs=bool(cfg.render_costs),
        out=Path(cfg.out),
    )


def _read_rungs(cfg: DictConfig) -> Rungs:
    epochs, seeds = _whole_numbers(cfg, "rungs"), _whole_numbers(cfg, "seeds")
    if list(epochs) != sorted(set(epochs)):
        raise UserError(f"Invalid rungs={list(epochs)}: list epochs from the shortest to the longest training.")
    if len(seeds) == 1:
        seeds *= len(epochs)
    if len(seeds) != len(epochs):
        raise UserError(f"Invalid seeds={list(seeds)}: use one number of seeds per rung of rungs={list(epochs)}.")
    return Rungs(epochs, seeds)


def _whole_numbers(cfg: DictConfig, key: str) -> tuple[int, ...]:
    value = cfg[key]
    numbers = tuple(value) if OmegaConf.is_list(value) else (value,)
    if not numbers or any(isinstance(n, bool) or not isinstance(n, int) or n < 1 for n in numbers):
        raise UserError(f"Invalid {key}={list(numbers)}: use a list of whole numbers of at least 1.")
    return numbers
