"""Slot ``history``: the channels that are handed from frame to frame (Mercier et al. 2023, section 4.2)."""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn


class History(nn.Module, ABC):
    """The step from the network's prediction to the output and the new history.

    ``carried`` counts the channels at target resolution that are handed from frame to frame, colour first; ``extra``
    names the channels that the network predicts beside the three of the colour candidate.

    The paper names no activation for the recurrent feature. It is a tanh here: without a bound nothing keeps the loop
    through the network from growing, and in a trial it grew from 1e9 at frame 10 to infinity.
    """

    carried: int
    extra: tuple[str, ...]

    def start(self, color: Tensor) -> Tensor:
        """Return the history before the first frame: its upsampled ``color (B, 3, H, W)``, and features of 0."""
        return F.pad(color, (0, 0, 0, 0, 0, self.carried - 3))

    @abstractmethod
    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        """Return ``(output (B, 3, H, W), history (B, carried, H, W))``.

        Args:
            candidate: colour ``(B, 3, H, W)`` in [0, 1].
            extra: ``(B, len(self.extra), H, W)``, unbounded.
            previous: the history warped to this frame ``(B, carried, H, W)``; None if ``carried`` is 0.
        """

    @abstractmethod
    def images(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> dict[str, Tensor]:
        """Return what the step combines (figure 5): images ``(B, 1 or 3, H, W)`` in [0, 1] by name.

        Arguments are those of `forward`.
        """


@final
class Blended(History):
    """The candidate blended with the previous output by a mask (eq 3), and one feature channel."""

    carried = 4
    extra = ("mask", "feature")

    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        assert previous is not None
        mask, feature = extra.split(1, dim=1)
        # Bilinear weights sum to 1 except for rounding, which would add up over frames without the clamp.
        output = torch.lerp(previous[:, :3], candidate, mask.sigmoid()).clamp(0.0, 1.0)
        return output, torch.cat((output, feature.tanh()), dim=1)

    def images(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> dict[str, Tensor]:
        """Return the reprojected output, the candidate, and the mask: 1 where the candidate replaces the history."""
        assert previous is not None
        return {"reprojected": previous[:, :3].clamp(0.0, 1.0), "candidate": candidate, "mask": extra[:, :1].sigmoid()}


@final
class Unblended(History):
    """The candidate as the output, without a mask: the row "(-) blending" of table 3.

    The network still reads colour and feature of the previous frame.
    """

    carried = 4
    extra = ("feature",)

    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        return candidate, torch.cat((candidate, extra.tanh()), dim=1)

    def images(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> dict[str, Tensor]:
        assert previous is not None
        return {"reprojected": previous[:, :3].clamp(0.0, 1.0)}


@final
class NoHistory(History):
    """No history: the network reads one frame and predicts colour only; the row "(-) multiple frames" of table 3."""

    carried = 0
    extra = ()

    def forward(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> tuple[Tensor, Tensor]:
        return candidate, candidate[:, :0]

    def images(self, candidate: Tensor, extra: Tensor, previous: Tensor | None) -> dict[str, Tensor]:
        return {}
