"""Slot ``history``: what a frame keeps of the one before (Mercier et al. 2023, section 4.2)."""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn


class History(nn.Module, ABC):
    """Makes output and history of what the network predicts.

    ``carried`` counts the channels at target resolution that are handed from frame to frame, colour first; ``extra`` those that
    the network predicts beside the colour candidate's three.

    The paper names no activation for the recurrent feature. It is a tanh here: without a bound nothing keeps the loop through
    the network from growing, and in a trial it went from 1e9 at frame 10 to infinity.
    """

    carried: int
    extra: tuple[str, ...]

    def start(self, color: Tensor) -> Tensor:
        """The history before the first frame, of its upsampled ``color (B, 3, H, W)``: that colour, features 0."""
        return F.pad(color, (0, 0, 0, 0, 0, self.carried - 3))

    @abstractmethod
    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        """``(output (B, 3, H, W), history (B, carried, H, W))``.

        Args:
            candidate: colour ``(B, 3, H, W)`` in [0, 1].
            extra: ``(B, len(self.extra), H, W)``, unbounded.
            previous: the history brought to this frame ``(B, carried, H, W)``; None where ``carried`` is 0.
        """


@final
class Blended(History):
    """The candidate blended with the previous output by a mask (eq 3), and one feature channel."""

    carried = 4
    extra = ("mask", "feature")

    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        assert previous is not None
        mask, feature = extra.split(1, dim=1)
        # Bilinear weights sum to 1 but for rounding, which would add up over frames without the clamp.
        output = torch.lerp(previous[:, :3], candidate, mask.sigmoid()).clamp(0.0, 1.0)
        return output, torch.cat((output, feature.tanh()), dim=1)


@final
class Unblended(History):
    """The candidate is the output, no mask is predicted; the network still reads colour and feature of the previous frame: the
    row "(-) blending" of table 3."""

    carried = 4
    extra = ("feature",)

    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        return candidate, torch.cat((candidate, extra.tanh()), dim=1)


@final
class NoHistory(History):
    """Nothing is kept: the network sees one frame and predicts colour alone: the row "(-) multiple frames" of table 3."""

    carried = 0
    extra = ()

    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        return candidate, candidate[:, :0]
