"""Losses that compare pixel with pixel."""

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
    """``d^2 / (2 beta)`` below ``beta``, ``|d| - beta / 2`` from there on; the first term of Li et al. 2024, eq 6.

    Args:
        beta: above 0, in the method's domain. The paper gives none: 1, as in the Fast R-CNN paper that it cites.
    """

    requires = frozenset[str]()
    previous = 0

    def __init__(self, beta: float) -> None:
        super().__init__()
        self.beta = check_beta(beta)

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        return F.smooth_l1_loss(outputs, targets, beta=self.beta)


def check_beta(beta: float) -> float:
    """``beta`` itself; raises `UserError` unless it is above 0 (at 0 the loss is an L1, which has a name)."""
    if not 0.0 < beta < float("inf"):
        raise UserError(f"beta of smooth L1 must be above 0, got {beta}; 1 is the default, and l1 the limit at 0.")
    return beta
