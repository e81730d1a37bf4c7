"""Training losses over a clip's counted frames."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import final

from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.ops.temporal import carry_error, spatiotemporal_error


class Loss(nn.Module, ABC):
    """``forward(outputs, targets, frames) -> scalar``.

    ``outputs`` and ``targets`` are ``(B, previous + K, 3, H, W)``: the ``K`` frames that count, after the ``previous`` frames
    that the loss looks back to, in the method's own domain (`models.base.Upsampler.reference`). ``frames`` holds the same
    frames' low-resolution buffers ``(B, previous + K, C, h, w)``; ``requires`` names those that are read.
    """

    requires: frozenset[str]
    previous: int

    @abstractmethod
    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor: ...


@final
class L1(Loss):
    """Mean absolute error (Swensen 2021, eq 7)."""

    requires = frozenset[str]()
    previous = 0

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        return (outputs - targets).abs().mean()


@final
class SpatioTemporal(Loss):
    """The linearised spatio-temporal loss (Swensen 2021, eqs 54 and 55): ``|x| + |y| + theta (|x - y| - |x| -
    |y|)``.

    ``x`` is the frame's error, ``y`` the previous frame's, warped here. ``theta = 0`` is spatial only, and
    twice an L1 in size; towards 1 only changes of the error count, and at 1 nothing ties the output to the
    target.
    """

    requires = frozenset({"motion"})
    previous = 1

    def __init__(self, theta: float) -> None:
        super().__init__()
        if not 0.0 <= theta <= 1.0:
            raise UserError(f"loss.theta must lie in [0, 1], got {theta}; the thesis tries 0.1, 0.5 and 0.9.")
        self.theta = theta

    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor:
        motion = frames["motion"]
        error = outputs - targets
        carried = carry_error(error[:, :-1].flatten(0, 1), motion[:, 1:].flatten(0, 1))
        return spatiotemporal_error(error[:, 1:].flatten(0, 1), carried, self.theta).mean()
