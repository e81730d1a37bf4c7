"""The settings of ``advise.py``, checked once."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf

from supersampling.advice.cost import Size
from supersampling.advice.space import Space, read_space
from supersampling.advice.trainings import Rungs
from supersampling.errors import UserError

SEARCHES = ("halving", "optuna")


@dataclass(frozen=True)
class Settings:
    """What a search is made by; ``steps`` is None without a limit."""

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


def settings_of(cfg: DictConfig) -> Settings:
    """Those of a configuration.

    Raises:
        UserError: one that is not possible.
    """
    margin = cfg.margin
    if isinstance(margin, bool) or not isinstance(margin, (int, float)) or not 0 < margin < 100:
        raise UserError(
            f"margin={margin} is not possible: say how many dB, above 0, the answer may be worse than the best."
        )
    if cfg.search not in SEARCHES:
        raise UserError(f"search={cfg.search} is none of {', '.join(SEARCHES)}.")
    epochs, seeds = _whole(cfg, "rungs"), _whole(cfg, "seeds")
    if list(epochs) != sorted(set(epochs)):
        raise UserError(f"rungs={list(epochs)} do not rise: give epochs from the shortest to the longest.")
    if len(seeds) == 1:
        seeds *= len(epochs)
    if len(seeds) != len(epochs):
        raise UserError(f"seeds={list(seeds)} are not one for each of rungs={list(epochs)}: give as many.")
    if OmegaConf.select(cfg, "among") is None:
        raise UserError(
            "This model has no space of its own: set among=dlctus, nsrr, nsrd, enss or models, or write one into conf/among/."
        )
    size = _whole(cfg, "size")
    if len(size) != 2 or max(size) > 2**15:
        raise UserError(f"size={list(size)} is not possible: use [width,height] of the low-resolution input in pixels.")
    return Settings(
        read_space(OmegaConf.to_container(cfg.among, resolve=True)),
        float(margin),
        Rungs(epochs, seeds),
        None if cfg.steps is None else _count(cfg, "steps"),
        str(cfg.search),
        _count(cfg, "trials"),
        _count(cfg, "walk"),
        bool(cfg.prune),
        Size(*size),
        _count(cfg, "frames"),
        bool(cfg.render_costs),
        Path(cfg.out),
    )


def _count(cfg: DictConfig, key: str) -> int:
    value = cfg[key]
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise UserError(f"{key}={value} is not possible: use a whole number from 1 up.")
    return value


def _whole(cfg: DictConfig, key: str) -> tuple[int, ...]:
    given: Any = OmegaConf.to_container(cfg)[key]  # type: ignore[index, call-overload]
    values = given if isinstance(given, list) else [given]
    if not values or any(isinstance(v, bool) or not isinstance(v, int) or v < 1 for v in values):
        raise UserError(f"{key}={given} is not possible: use a list of whole numbers from 1 up.")
    return tuple(values)
