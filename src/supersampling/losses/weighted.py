"""Weighted sum of losses."""

import math
from collections.abc import Callable, Mapping
from typing import final

from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.losses.base import Loss


@final
class Sum(Loss):
    """Sum of ``weights[name] * terms[name]`` over the same ``K`` counted frames.

    A term with weight 0 is never constructed, reads no buffers and costs nothing. ``previous`` is the maximum over the
    remaining terms; each of them receives the counted frames, preceded by as many frames as it looks back to.

    Args:
        terms: factories of the losses, called without arguments.
        weights: by names of ``terms``; finite and non-negative, at least one of them positive.
    """

    def __init__(self, terms: Mapping[str, Callable[[], Loss]], weights: Mapping[str, float]) -> None:
        super().__init__()
        for name, weight in weights.items():
            if name not in terms:
                raise UserError(f"Unknown term of loss.weights.{name}: use one of {', '.join(terms)}.")
            if not isinstance(weight, (int, float)) or not 0.0 <= weight < math.inf:
                raise UserError(
                    f"Invalid loss.weights.{name}={weight}: use a number that is at least 0 (0 disables the term)."
                )
        self.weights = {name: float(weight) for name, weight in weights.items() if weight}
        if not self.weights:
            raise UserError("All loss.weights are 0: set at least one, e.g. loss.weights.l1=1.")
        losses = {name: terms[name]() for name in self.weights}
        self._losses = nn.ModuleDict(losses)
        self.requires = frozenset[str]().union(*(loss.requires for loss in losses.values()))
        self.previous = max(loss.previous for loss in losses.values())

    def terms(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> dict[str, Tensor]:
        values = {}
        for name, loss in self._losses.items():
            assert isinstance(loss, Loss)
            first = self.previous - loss.previous
            buffers = {buffer: frames[buffer][:, first:] for buffer in loss.requires}
            values[name] = self.weights[name] * loss(outputs[:, first:], targets[:, first:], buffers)
        return values

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        total, *rest = self.terms(outputs, targets, frames).values()
        for value in rest:
            total = total + value
        return total
