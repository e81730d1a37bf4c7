"""Slot ``guides``: buffers that a network reads beside colour and depth (Li et al. 2024, NSRD, table 5, "+GBuffer")."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame

# Numbers of objects mean nothing to a convolution, and depth is read by whoever has this slot.
CHANNELS = {
    b.name: b.channels for b in BUFFERS.values() if b.resolution == "low" and b.kind != "id" and b.name != "depth"
}


class Guides(nn.Module, ABC):
    """``forward(samples (B, C, h, w), frame) -> (B, C + channels, h, w)``: the samples, then the guides.

    ``requires`` names the buffers that are read.
    """

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def forward(self, samples: Tensor, frame: Frame) -> Tensor: ...


@final
class NoGuides(Guides):
    """The samples alone."""

    channels = 0
    requires = frozenset[str]()

    def forward(self, samples: Tensor, frame: Frame) -> Tensor:
        return samples


@final
class GBuffers(Guides):
    """Low-resolution buffers as they are (`supersampling.frames`), in the order of their names.

    Args:
        names: any of `CHANNELS`, each once. NSRD gives the methods that it compares with depth and normal.

    Raises:
        UserError: another name, or one twice.
    """

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__()
        given = [names] if isinstance(names, str) else list(names)
        wrong = [name for k, name in enumerate(given) if name not in CHANNELS or name in given[:k]]
        if wrong:
            raise UserError(
                f"model.guides.names holds {wrong[0]}, which is no low-resolution buffer to add, or is there already: use "
                f"a list of {', '.join(CHANNELS)}, each once."
            )
        self.names = tuple(given)
        self.channels = sum(CHANNELS[name] for name in self.names)
        self.requires = frozenset(self.names)

    def forward(self, samples: Tensor, frame: Frame) -> Tensor:
        return torch.cat((samples, *(frame.need(name) for name in self.names)), dim=1)
