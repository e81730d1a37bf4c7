"""Slot ``recur``: the recurrence from the previous frame's network (Li et al. 2024, NSRD, section 3.3 and table 6)."""

from abc import ABC, abstractmethod
from typing import Protocol, final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.ops.warp import warp
from supersampling.stages.gate import OPEN, SHUT, Gate, bias_at

FEATURES = 32  # of the previous output (supplement, 4.2)


class Recur(nn.Module, ABC):
    """The recurrent step of the network.

    ``forward(shallow (B, C, h, w), motion (B, 2, s h, s w), carried) -> (features (B, width, h, w), memory)``.

    ``motion`` is given at the output's pixels, in units of the image. ``carried`` is what `carry` returned for the
    previous frame's output and ``memory``, ``()`` on a clip's first frame. Both are tuples of tensors, batch first.
    """

    @abstractmethod
    def forward(
        self, shallow: Tensor, motion: Tensor, carried: tuple[Tensor, ...]
    ) -> tuple[Tensor, tuple[Tensor, ...]]: ...

    @abstractmethod
    def carry(self, output: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
        """Return what the next frame needs of the current output ``(B, 3, s h, s w)`` and memory."""


class MakeRecur(Protocol):
    """A `Recur` class, or a partial of one; the model supplies the widths."""

    def __call__(self, *, channels: int, width: int, scale: int) -> Recur: ...


class ConvLSTM(nn.Module):
    """One step of Shi et al. 2015 (equation 3, without its peepholes, which agrees with the published parameter count).

    ``forward(x (B, channels, h, w), hidden, cell (B, width, h, w)) -> (hidden, cell)``. The cell keeps its own type, so
    that under autocast its sum over a whole clip stays in float32.
    """

    def __init__(self, channels: int, width: int) -> None:
        super().__init__()
        self.gates = nn.Conv2d(channels + width, 4 * width, 3, padding=1)

    def forward(self, x: Tensor, hidden: Tensor, cell: Tensor) -> tuple[Tensor, Tensor]:
        gates = self.gates(torch.cat((x, hidden.to(x.dtype)), dim=1)).to(cell.dtype)
        write, keep, show, value = gates.chunk(4, dim=1)
        cell = keep.sigmoid() * cell + write.sigmoid() * value.tanh()
        return show.sigmoid() * cell.tanh(), cell


def _bias_of_gates(stage: "Recurrent") -> Tensor | None:
    """Return the bias of the gates write, keep and show, ``(3 * width,)``, without that of the value."""
    bias = stage.lstm.gates.bias
    return None if bias is None else bias[: 3 * stage.width]


@final
class Recurrent(Recur):
    """The previous output and a ConvLSTM's state.

    The output is warped, with borders repeated, and rearranged into ``3 s**2`` low-resolution channels. A clip's first
    frame has zeros for the output and for the state.

    Args:
        channels: number ``C`` of shallow features.
        width: channels of the ConvLSTM's state.
        scale: ``s``.
    """

    extremes = (
        Gate("gate/cell keeps all", "NSRD: the cell adds up and never forgets.", bias_at(OPEN, _bias_of_gates)),
        Gate("gate/cell keeps nothing", "NSRD: all gates of the cell are shut.", bias_at(SHUT, _bias_of_gates)),
    )

    def __init__(self, *, channels: int, width: int, scale: int) -> None:
        super().__init__()
        self.width, self.scale = width, scale
        self.first = nn.Conv2d(3 * scale**2, FEATURES, 3, padding=1)
        self.lstm = ConvLSTM(channels + FEATURES, width)

    def forward(
        self, shallow: Tensor, motion: Tensor, carried: tuple[Tensor, ...]
    ) -> tuple[Tensor, tuple[Tensor, ...]]:
        b, _, height, width = motion.shape
        if carried:
            output, hidden, cell = carried
            # Values that are not finite are dropped: the cell and the loop through the network would keep them.
            previous = torch.nan_to_num(warp(output, motion), 0.0, 0.0, 0.0)
            hidden, cell = (torch.nan_to_num(memory, 0.0, 0.0, 0.0) for memory in (hidden, cell))
        else:
            previous = motion.new_zeros((b, 3, height, width))
            hidden = cell = motion.new_zeros((b, self.width, height // self.scale, width // self.scale))
        features = self.first(F.pixel_unshuffle(previous, self.scale))
        hidden, cell = self.lstm(torch.cat((shallow, features), dim=1), hidden, cell)
        return hidden, (hidden, cell)

    def carry(self, output: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
        return output, *memory


@final
class NotRecurrent(Recur):
    """No recurrence: a convolution and a ReLU take the place of the ConvLSTM.

    The paper does not say how row A of its table 6 was wired. Arguments as in `Recurrent`; ``scale`` is not used.
    """

    def __init__(self, *, channels: int, width: int, scale: int) -> None:
        super().__init__()
        self.first = nn.Conv2d(channels, width, 3, padding=1)

    def forward(
        self, shallow: Tensor, motion: Tensor, carried: tuple[Tensor, ...]
    ) -> tuple[Tensor, tuple[Tensor, ...]]:
        return self.first(shallow).relu(), ()

    def carry(self, output: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
        return ()
