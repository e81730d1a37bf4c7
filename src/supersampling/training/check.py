"""Checks of the numbers that decide a training, made once at the boundary."""

from omegaconf import DictConfig, OmegaConf

from supersampling.errors import UserError

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
    "optimizer.lr": (float, 0.0, 1e3),
}


def check_numbers(cfg: DictConfig) -> None:
    """Raise `UserError` for a number of another type or outside of its range; numbers of a model or loss check
    themselves."""
    for key, (kind, low, high) in _NUMBERS.items():
        value = OmegaConf.select(cfg, key)
        if value is None:
            continue
        allowed = (int,) if kind is int else (int, float)
        if isinstance(value, bool) or not isinstance(value, allowed) or not low <= value <= high:
            word = "a whole number" if kind is int else "a number"
            raise UserError(f"Invalid {key}={value}: use {word} between {low:g} and {high:g}.")
    counted, frames = OmegaConf.select(cfg, "budget.counted"), OmegaConf.select(cfg, "budget.frames")
    if counted is not None and counted > frames:
        raise UserError(f"Invalid budget.counted={counted}: use at most budget.frames={frames}, or unroll more frames.")
