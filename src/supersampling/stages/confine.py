"""Slot ``confine``: the map of the network's outputs into [0, 1] (Swensen 2021, 4.1.4).

The published clamp has no gradient outside [0, 1]. With the published initialisation about half of the outputs start
there, and a pixel whose blending weight is below 0 learns nothing until the gradients of other pixels move it.
"""

import math
from abc import ABC, abstractmethod
from typing import Any, final

import torch
from torch import Tensor, nn


class Confine(nn.Module, ABC):
    """An elementwise map ``forward(x) -> values in [0, 1]``; an initialisation finds its biases by ``inverse``."""

    @abstractmethod
    def forward(self, x: Tensor) -> Tensor: ...

    @abstractmethod
    def inverse(self, value: float) -> float:
        """Return the ``x`` that is mapped to ``value``, for ``value`` in (0, 1)."""


@final
class Clamp(Confine):
    """The published function with its own gradient."""

    def forward(self, x: Tensor) -> Tensor:
        return x.clamp(0.0, 1.0)

    def inverse(self, value: float) -> float:
        return value


@final
class StraightThrough(Confine):
    """The clamp's values, bit for bit; outside [0, 1] a gradient passes if descent moves ``x`` back inside."""

    def forward(self, x: Tensor) -> Tensor:
        result: Tensor = _ClampStraightThrough.apply(x)
        return result

    def inverse(self, value: float) -> float:
        return value


@final
class Sigmoid(Confine):
    """A smooth map that never quite reaches 0 or 1: not the published function."""

    def forward(self, x: Tensor) -> Tensor:
        return x.sigmoid()

    def inverse(self, value: float) -> float:
        return math.log(value / (1.0 - value))


class _ClampStraightThrough(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, x: Tensor) -> Tensor:
        ctx.save_for_backward(x)
        return x.clamp(0.0, 1.0)

    @staticmethod
    def backward(ctx: Any, *grads: Tensor) -> Tensor:
        (x,) = ctx.saved_tensors
        (grad,) = grads
        # Descent subtracts the gradient: a positive one below 0, or a negative one above 1, would lead further out.
        outwards = ((x < 0.0) & (grad > 0.0)) | ((x > 1.0) & (grad < 0.0))
        return grad.masked_fill(outwards, 0.0)
