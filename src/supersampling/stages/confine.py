"""Slot ``confine``: how the network's outputs are brought into [0, 1] (Swensen 2021, 4.1.4).

The published clamp has no gradient outside [0, 1]. With the published initialisation about half of the
outputs start there, and a pixel whose blending weight sits below 0 learns nothing until others move it.
"""

import math
from abc import ABC, abstractmethod
from typing import Any, final

import torch
from torch import Tensor, nn


class Confine(nn.Module, ABC):
    """``forward(x) -> values in [0, 1]`` elementwise; ``inverse`` tells an initialisation where to start."""

    @abstractmethod
    def forward(self, x: Tensor) -> Tensor: ...

    @abstractmethod
    def inverse(self, value: float) -> float:
        """The ``x`` that gives ``value``, for ``value`` in (0, 1)."""


@final
class Clamp(Confine):
    """The published function with its own gradient."""

    def forward(self, x: Tensor) -> Tensor:
        return x.clamp(0.0, 1.0)

    def inverse(self, value: float) -> float:
        return value


@final
class StraightThrough(Confine):
    """The clamp's values to the bit; outside [0, 1] the gradient passes where descent leads back inside."""

    def forward(self, x: Tensor) -> Tensor:
        result: Tensor = _ClampStraightThrough.apply(x)
        return result

    def inverse(self, value: float) -> float:
        return value


@final
class Sigmoid(Confine):
    """A smooth map that never quite reaches 0 or 1; another function than the published one."""

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
        # Descent subtracts the gradient: below 0 a positive one would lead further out, above 1 a negative
        # one.
        lost = ((x < 0.0) & (grad > 0.0)) | ((x > 1.0) & (grad < 0.0))
        return grad.masked_fill(lost, 0.0)
