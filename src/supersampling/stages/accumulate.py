"""Slot ``accumulate``: the channels of the history beside colour (Swensen 2021, 4.1.5 and 5.5.3)."""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn


class Accumulate(nn.Module, ABC):
    """The owner of the history's channels beside colour; ``channels`` is the history's total."""

    channels: int

    @abstractmethod
    def append(self, color: Tensor) -> Tensor:
        """Return the history channels ``(B, channels, H, W)`` of an input colour ``(B, 3, H, W)``."""

    @abstractmethod
    def state_images(self, history: Tensor) -> dict[str, Tensor]:
        """Return a history's channels beside colour by name, each ``(B, 1, H, W)`` in [0, 1] (table 17)."""

    @abstractmethod
    def forward(self, blended: Tensor, keep: Tensor) -> Tensor:
        """Return the new history from the blended one ``(B, channels, H, W)`` and ``o2 (B, 1, H, W)``."""


@final
class AccumulationBuffer(Accumulate):
    """A fourth channel: 1 for a single input sample, towards 0 as samples accumulate; multiplied by ``o2`` (eq 45)."""

    channels = 4

    def append(self, color: Tensor) -> Tensor:
        return F.pad(color, (0, 0, 0, 0, 0, 1), value=1.0)

    def state_images(self, history: Tensor) -> dict[str, Tensor]:
        return {"accumulation": history[:, 3:4]}

    def forward(self, blended: Tensor, keep: Tensor) -> Tensor:
        return torch.cat((blended[:, :3], blended[:, 3:] * keep), dim=1)


@final
class NoAccumulation(Accumulate):
    """Colour only: the network reads 7 channels and ``o2`` is not used.

    The thesis does not say how the variant of its table 16 was wired; this is the smallest change that removes the
    buffer.
    """

    channels = 3

    def append(self, color: Tensor) -> Tensor:
        return color

    def state_images(self, history: Tensor) -> dict[str, Tensor]:
        return {}

    def forward(self, blended: Tensor, keep: Tensor) -> Tensor:
        return blended
