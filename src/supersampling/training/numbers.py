"""The numbers that decide a training, checked for every command; this file imports no library that loads slowly."""

from omegaconf import DictConfig, OmegaConf

from supersampling.errors import UserError

SMALLEST_RATE = 1e-12  # a training at a rate of 0 learns nothing

# Type, lowest and highest value of each key.
_NUMBERS: dict[str, tuple[type, float, float]] = {
    "seed": (int, 0, 2**32 - 1),
    "threads": (int, 1, 4096),
    "workers": (int, 0, 256),
    "task.scale": (int, 2, 6),
    "budget.epochs": (int, 1, 1e6),
    "budget.steps": (int, 1, 1e9),
    "budget.batch": (int, 1, 1e6),
    "budget.crop": (int, 8, 1e5),
    "budget.frames": (int, 1, 1e6),
    "budget.counted": (int, 1, 1e6),
    "budget.validate_every": (int, 1, 1e6),
    "budget.lr": (float, SMALLEST_RATE, 1e3),
    "optimizer.lr": (float, SMALLEST_RATE, 1e3),
}


def check_numbers(cfg: DictConfig) -> None:
    """Raise `UserError` for a number of another type or outside of its range; numbers of a model or loss check
    themselves."""
    for key, (kind, low, high) in _NUMBERS.items():
        group, _, name = key.rpartition(".")
        parent = OmegaConf.select(cfg, group) if group else cfg
        if parent is None or name not in parent:
            continue
        value = OmegaConf.select(cfg, key)
        allowed = (int,) if kind is int else (int, float)
        if isinstance(value, bool) or not isinstance(value, allowed) or not low <= value <= high:
            word = "a whole number" if kind is int else "a number"
            raise UserError(f"Invalid {key}={value}: use {word} between {low:g} and {high:g}.")
    counted, frames = OmegaConf.select(cfg, "budget.counted"), OmegaConf.select(cfg, "budget.frames")
    if counted is not None and counted > frames:
        raise UserError(f"Invalid budget.counted={counted}: use at most budget.frames={frames}, or unroll more frames.")
