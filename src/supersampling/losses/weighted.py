"""A weighted sum of losses."""

import math
from collections.abc import Callable, Mapping
from typing import final

from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.losses.base import Loss


@final
class Sum(Loss):
    """``sum of weights[name] * terms[name]`` over the same ``K`` counted frames.

    A term of weight 0 is left out altogether: it is not made, reads no buffers and costs nothing. ``previous`` is the longest
    look back among the others, each of which gets the counted frames after those that it looks back to itself.

    Args:
        terms: what makes each loss, called without arguments.
        weights: finite, 0 or more, one at least above 0; names of ``terms``.
    """

    def __init__(self, terms: Mapping[str, Callable[[], Loss]], weights: Mapping[str, float]) -> None:
        super().__init__()
        for name, weight in weights.items():
            if name not in terms:
                raise UserError(f"loss.weights.{name} has no term: use one of {', '.join(terms)}.")
            if not isinstance(weight, (int, float)) or not 0.0 <= weight < math.inf:
                raise UserError(f"loss.weights.{name}={weight} is not possible: use 0 or more (0 leaves it out).")
        self.weights = {name: float(weight) for name, weight in weights.items() if weight}
        if not self.weights:
            raise UserError("All loss.weights are 0: set one, e.g. loss.weights.l1=1.")
        made = {name: terms[name]() for name in self.weights}
        self._made = nn.ModuleDict(made)
        self.requires = frozenset[str]().union(*(term.requires for term in made.values()))
        self.previous = max(term.previous for term in made.values())

    def terms(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> dict[str, Tensor]:
        values = {}
        for name, term in self._made.items():
            assert isinstance(term, Loss)
            first = self.previous - term.previous
            read = {buffer: frames[buffer][:, first:] for buffer in term.requires}
            values[name] = self.weights[name] * term(outputs[:, first:], targets[:, first:], read)
        return values

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        total, *others = self.terms(outputs, targets, frames).values()
        for value in others:
            total = total + value
        return total
