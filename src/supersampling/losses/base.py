"""What every training loss is."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

from torch import Tensor, nn


class Loss(nn.Module, ABC):
    """``forward(outputs, targets, frames) -> scalar``.

    ``outputs`` and ``targets`` are ``(B, previous + K, 3, H, W)``: the ``K`` frames that count, after the ``previous`` frames
    that the loss looks back to, in the method's own domain (`models.base.Upsampler.reference`), which may be unbounded.
    ``frames`` holds the same frames' low-resolution buffers ``(B, previous + K, C, h, w)``; ``requires`` names those that are
    read. A loss has nothing to learn and leaves nothing in a checkpoint.
    """

    requires: frozenset[str]
    previous: int

    @abstractmethod
    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor: ...

    def terms(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The parts by name, each with its weight; their sum is the loss."""
        return {type(self).__name__: self(outputs, targets, frames)}
