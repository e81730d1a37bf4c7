"""Base class of training losses."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

from torch import Tensor, nn


class Loss(nn.Module, ABC):
    """Training loss: ``forward(outputs, targets, frames) -> scalar``.

    ``outputs`` and ``targets`` are ``(B, previous + K, 3, H, W)``: the ``previous`` frames that the loss looks back to,
    followed by the ``K`` counted frames, in the domain of the method (`models.base.Upsampler.reference`), which may be
    unbounded. ``frames`` maps the names of low-resolution buffers of the same frames to ``(B, previous + K, C, h, w)``;
    ``requires`` names the buffers that are read. A loss has no parameters and saves nothing in a checkpoint.
    """

    requires: frozenset[str]
    previous: int
    label: str = ""  # the number that a run's name shows, such as theta=0.1; empty: the name shows the loss's option

    @abstractmethod
    def forward(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> Tensor: ...

    def terms(self, outputs: Tensor, targets: Tensor, frames: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Return the weighted terms by name; their sum is the loss."""
        return {type(self).__name__: self(outputs, targets, frames)}
