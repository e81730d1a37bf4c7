"""Checks of settings that several commands have, each with one sentence for a mistake."""

from collections.abc import Collection, Sequence
from typing import Any

import torch
from omegaconf import DictConfig, OmegaConf

from supersampling.errors import UserError

LARGEST_SIDE = 2**15  # pixels


def whole(cfg: DictConfig, key: str, least: int = 1) -> int:
    """Return the whole number of a key.

    Raises:
        UserError: it is of another type, or below ``least``.
    """
    value = OmegaConf.select(cfg, key)
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise UserError(f"Invalid {key}={value}: use a whole number of at least {least}.")
    return value


def number(cfg: DictConfig, key: str, low: float, high: float) -> float:
    """Return the number of a key.

    Raises:
        UserError: it is of another type, or outside of ``low`` to ``high``.
    """
    value = OmegaConf.select(cfg, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise UserError(f"Invalid {key}={value}: use a number between {low:g} and {high:g}.")
    return float(value)


def positive(cfg: DictConfig, key: str) -> float:
    """Return the number of a key.

    Raises:
        UserError: it is of another type, or not positive.
    """
    value = OmegaConf.select(cfg, key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0:
        raise UserError(f"Invalid {key}={value}: use a positive number.")
    return float(value)


def choice(cfg: DictConfig, key: str, options: Collection[str]) -> str:
    """Return the word of a key.

    Raises:
        UserError: it is not among the options.
    """
    value = OmegaConf.select(cfg, key)
    if value not in options:
        raise UserError(f"Invalid {key}={value}: use {' or '.join(options)}.")
    return str(value)


def is_size(value: Any, largest: int = LARGEST_SIDE) -> bool:
    """Return whether a value is a width and a height in pixels."""
    sides = list(value) if OmegaConf.is_list(value) or isinstance(value, (list, tuple)) else []
    return len(sides) == 2 and all(isinstance(n, int) and not isinstance(n, bool) and 1 <= n <= largest for n in sides)


def size(value: Sequence[Any], key: str, largest: int = LARGEST_SIDE) -> tuple[int, int]:
    """Return the width and height of the low-resolution input.

    Raises:
        UserError: it is not two whole numbers from 1 to ``largest``.
    """
    if not is_size(value, largest):
        text = list(value) if OmegaConf.is_list(value) else value
        raise UserError(
            f"Invalid {key}={text}: use [width,height] of the low-resolution input in pixels, at most {largest} each."
        )
    width, height = value
    return int(width), int(height)


def device(name: str | None) -> torch.device:
    """Return the device called ``name``; for ``auto`` or None, an accelerator if there is one.

    Raises:
        UserError: this machine does not have the device.
    """
    available = ["cpu", *(["cuda"] if torch.cuda.is_available() else [])]
    if name in (None, "auto"):
        return torch.device(available[-1])
    if name not in available:
        raise UserError(f"This machine has no device={name}: use {', '.join(available)} or auto.")
    return torch.device(name)


def exclusive(cfg: DictConfig, *keys: str) -> str | None:
    """Return which of the keys is set, None if none is.

    Raises:
        UserError: several are set.
    """
    selected = [key for key in keys if cfg[key]]
    if len(selected) > 1:
        settings = " and ".join(f"{key}={cfg[key]}" for key in selected[:2])
        raise UserError(f"{settings} exclude each other: set one of them.")
    return selected[0] if selected else None
