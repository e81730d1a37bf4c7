"""Slot ``initialise``: the weights that training starts from."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import final

import torch
from torch import nn

from supersampling.errors import UserError
from supersampling.stages.confine import Confine


class Initialise(ABC):
    """An initialisation of a new residual network ``first(x) + last_1(...) + ... + last_n(...)``.

    A method calls it once; the layers have PyTorch's default initialisation by then.
    """

    @abstractmethod
    def __call__(self, first: nn.Conv2d, lasts: Sequence[nn.Conv2d], confine: Confine) -> None: ...


@final
class Published(Initialise):
    """PyTorch's default, as in the thesis's listing: about half of the outputs start outside [0, 1]."""

    def __call__(self, first: nn.Conv2d, lasts: Sequence[nn.Conv2d], confine: Confine) -> None:
        return None


@final
class Balanced(Initialise):
    """Outputs that start near given values inside (0, 1), so that hardly any clamp is saturated.

    The convolutions that add to the output are scaled by ``gain``, and their biases set to 0; the last one's bias holds
    ``blend`` (``o1``) in the first half of the channels and ``keep`` (``o2``) in the second.
    """

    def __init__(self, blend: float = 0.15, keep: float = 0.9, gain: float = 0.2) -> None:
        for name, value in (("blend", blend), ("keep", keep)):
            if not 0.0 < value < 1.0:
                raise UserError(
                    f"Invalid initialise.{name}={value}: use a value inside (0, 1); the defaults are 0.15 and 0.9."
                )
        self.blend, self.keep, self.gain = blend, keep, gain

    @torch.no_grad()
    def __call__(self, first: nn.Conv2d, lasts: Sequence[nn.Conv2d], confine: Confine) -> None:
        for conv in (first, *lasts):
            assert conv.bias is not None
            conv.weight.mul_(self.gain)
            conv.bias.zero_()
        bias = lasts[-1].bias
        assert bias is not None
        half = bias.numel() // 2
        bias[:half] = confine.inverse(self.blend)
        bias[half:] = confine.inverse(self.keep)
