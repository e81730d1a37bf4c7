"""A gate of a model or of a stage that stress tests hold open or shut. This module is no slot."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn

OPEN, SHUT = 1e4, -1e4  # biases that no other term of their sum reaches


@dataclass(frozen=True)
class Gate:
    """One entry of the class attribute ``extremes`` of a model or stage.

    ``name`` is that of its rows in the table of the stress tests, ``group/what``; stored tables keep it. ``meaning`` is
    a sentence that begins with the method's name. ``hold`` brings the module that declares the gate to the extreme, in
    place, and returns False where the module was composed without it.
    """

    name: str
    meaning: str
    hold: Callable[[Any], bool]


def bias_at(value: float, part: Callable[[Any], Tensor | None]) -> Callable[[Any], bool]:
    """Return a `Gate.hold` that fills ``part(module)`` with ``value``; ``part`` returns a view of a bias, or None."""

    @torch.no_grad()
    def hold(module: nn.Module) -> bool:
        bias = part(module)
        if bias is not None:
            bias.fill_(value)
        return bias is not None

    return hold


def setting_at(value: float, name: str) -> Callable[[Any], bool]:
    """Return a `Gate.hold` that sets the attribute ``name`` of a module to ``value``."""

    def hold(module: nn.Module) -> bool:
        setattr(module, name, value)
        return True

    return hold
