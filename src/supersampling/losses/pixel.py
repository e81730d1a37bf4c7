"""Losses that compare images pixel by pixel."""

from collections.abc import Mapping
from typing import final

import torch.nn.functional as F
from torch import Tensor

from supersampling.errors import UserError
from supersampling.losses.base import Loss


@final
class L1(Loss):
    """Mean absolute error (Swensen 2021, eq 7; Mercier et al. 2023, section 5.1)."""

    requires = frozenset[str]()
    previous = 0

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        return (outputs - targets).abs().mean()


@final
class MSE(Loss):
    """Mean squared error (Swensen 2021, eq 8)."""

    requires = frozenset[str]()
    previous = 0

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        return (outputs - targets).square().mean()


@final
class SmoothL1(Loss):
    """Smooth L1, the first term of Li et al. 2024, eq 6.

    ``d^2 / (2 beta)`` where ``|d| < beta``, otherwise ``|d| - beta / 2``.

    Args:
        beta: positive, in the method's domain. The paper does not give it: 1, as in the Fast R-CNN paper that it cites.
    """

    requires = frozenset[str]()
    previous = 0

    def __init__(self, beta: float) -> None:
        super().__init__()
        self.beta = check_beta(beta)

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        return F.smooth_l1_loss(outputs, targets, beta=self.beta)


def check_beta(beta: float) -> float:
    """Return ``beta``; raise `UserError` unless it is positive and finite (the limit at 0 is `L1`)."""
    if not 0.0 < beta < float("inf"):
        raise UserError(
            f"Invalid beta={beta} of smooth L1: use a positive number (default 1), or loss l1, the limit at 0."
        )
    return beta
