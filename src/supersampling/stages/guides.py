"""Slot ``guides``: more buffers for a network, beside colour and depth (Li et al. 2024, NSRD, table 5, "+GBuffer")."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.frames import BUFFERS, Frame

# A convolution cannot use object numbers, and every method with this slot reads depth already.
CHANNELS = {
    b.name: b.channels for b in BUFFERS.values() if b.resolution == "low" and b.kind != "id" and b.name != "depth"
}


class Guides(nn.Module, ABC):
    """The samples, then the guides: ``forward(samples (B, C, h, w), frame) -> (B, C + channels, h, w)``.

    ``requires`` names the buffers that are read.
    """

    channels: int
    requires: frozenset[str]

    @abstractmethod
    def forward(self, samples: Tensor, frame: Frame) -> Tensor: ...


@final
class NoGuides(Guides):
    """The samples only."""

    channels = 0
    requires = frozenset[str]()

    def forward(self, samples: Tensor, frame: Frame) -> Tensor:
        return samples


@final
class GBuffers(Guides):
    """Unchanged low-resolution buffers (`supersampling.frames`), in the order of ``names``.

    Args:
        names: any of `CHANNELS`, each once. NSRD gives depth and normal to the methods that it compares itself with.

    Raises:
        UserError: a name is not in `CHANNELS`, or is listed twice.
    """

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__()
        self.names = (names,) if isinstance(names, str) else tuple(names)
        for k, name in enumerate(self.names):
            if name not in CHANNELS or name in self.names[:k]:
                raise UserError(
                    f"Invalid entry {name} of model.guides.names, which cannot be added or is listed twice: use a list "
                    f"of {', '.join(CHANNELS)}, each once."
                )
        self.channels = sum(CHANNELS[name] for name in self.names)
        self.requires = frozenset(self.names)

    def forward(self, samples: Tensor, frame: Frame) -> Tensor:
        return torch.cat((samples, *(frame.need(name) for name in self.names)), dim=1)
