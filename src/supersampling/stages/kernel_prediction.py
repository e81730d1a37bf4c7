"""Slot ``kernel_prediction``: where the kernels of a network's first and last convolution come from (Mercier et al. 2023,
section 4.2, "Jitter-conditioned convolutions").

Kernels are 3x3: ``(B, outputs, inputs, 3, 3)``, or ``(1, ...)`` where all items share one. An option is made from the two
kernels that training starts from, ``(outputs, inputs, 3, 3)``.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from itertools import pairwise
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from supersampling.errors import UserError


def convolve(x: Tensor, kernel: Tensor, bias: Tensor) -> Tensor:
    """3x3 convolution of ``x (B, inputs, h, w)``, zeros outside the image, each item by its own kernel; ``bias (outputs,)``."""
    b, c, h, w = x.shape
    if kernel.shape[0] == 1:
        return F.conv2d(x, kernel[0], bias, padding=1)
    grouped = F.conv2d(x.reshape(1, b * c, h, w), kernel.flatten(0, 1), bias.repeat(b), padding=1, groups=b)
    return grouped.view(b, -1, h, w)


class KernelPrediction(nn.Module, ABC):
    """``forward(jitter (B, 2)) -> (first, last)``, the two kernels."""

    @abstractmethod
    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]: ...

    def __call__(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        first, last = super().__call__(jitter)
        return first, last

    @torch.no_grad()
    def precompute(self, jitters: Tensor) -> "KernelTable":
        """The kernels of a jitter sequence ``(N, 2)``, once and for all: what is deployed."""
        return KernelTable(jitters, *self(jitters))


class KernelMLP(nn.Module):
    """``forward(jitter (B, 2)) -> [kernel (B, outputs, inputs, 3, 3), ...]``; all kernels are outputs of one MLP.

    ``layers`` counts linear layers, the output's among them; ReLU between them. Only kernels are predicted, not biases. The
    output layer's bias starts as the ``initial`` kernels and is kept in their shapes, so that an optimizer that treats matrices
    in a way of their own sees it as such. The paper is silent on how the rest starts: the output layer's weights at 0, so that
    training starts from ordinary convolutions at any width; the hidden layers as PyTorch's own.
    """

    def __init__(self, initial: Sequence[Tensor], width: int, layers: int) -> None:
        super().__init__()
        if width < 1 or layers < 2:
            raise UserError(
                f"kernel_prediction needs a width from 1 and layers from 2 up, got width={width} and layers={layers}; "
                "the paper has 2048 and 7."
            )
        self._sizes = [kernel.numel() for kernel in initial]
        widths = [2, *[width] * (layers - 1)]
        hidden = [m for a, b in pairwise(widths) for m in (nn.Linear(a, b), nn.ReLU())]
        last = nn.Linear(width, sum(self._sizes), bias=False)
        nn.init.zeros_(last.weight)
        self.layers = nn.Sequential(*hidden, last)
        self.bias = nn.ParameterList(initial)

    def forward(self, jitter: Tensor) -> list[Tensor]:
        parts = self.layers(jitter).split(self._sizes, dim=1)
        return [part.unflatten(1, bias.shape) + bias for part, bias in zip(parts, self.bias)]


@final
class FirstAndLast(KernelPrediction):
    """Both are predicted, as the paper does: 7 layers, 2048 wide (section 5).

    The paper speaks of "an MLP" for both, which is taken at its word: one MLP gives both kernels.
    """

    def __init__(self, first: Tensor, last: Tensor, width: int, layers: int) -> None:
        super().__init__()
        self.mlp = KernelMLP((first, last), width, layers)

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        first, last = self.mlp(jitter)
        return first, last


@final
class FirstOnly(KernelPrediction):
    """The first is predicted, the last learned: the row "(-) last jitter conv" of table 3."""

    def __init__(self, first: Tensor, last: Tensor, width: int, layers: int) -> None:
        super().__init__()
        self.mlp = KernelMLP((first,), width, layers)
        self.last = nn.Parameter(last[None])

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        (first,) = self.mlp(jitter)
        return first, self.last


@final
class LastOnly(KernelPrediction):
    """The last is predicted, the first learned: the row "(-) first jitter conv" of table 3."""

    def __init__(self, first: Tensor, last: Tensor, width: int, layers: int) -> None:
        super().__init__()
        self.mlp = KernelMLP((last,), width, layers)
        self.first = nn.Parameter(first[None])

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        (last,) = self.mlp(jitter)
        return self.first, last


@final
class NoPrediction(KernelPrediction):
    """Two ordinary convolutions: the row "(-) jitter conv" of table 3."""

    def __init__(self, first: Tensor, last: Tensor) -> None:
        super().__init__()
        self.first = nn.Parameter(first[None])
        self.last = nn.Parameter(last[None])

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        return self.first, self.last


@final
class KernelTable(KernelPrediction):
    """Kernels made beforehand for each position of a jitter sequence: "no additional computational overhead" (section 4.2).

    A jitter takes the entry that is nearest to it; one from outside the sequence gets a kernel that was made for another.

    Args:
        jitters: ``(N, 2)``.
        first, last: ``(N, outputs, inputs, 3, 3)``, or ``(1, ...)`` for a kernel that no jitter changes.
    """

    jitters: Tensor
    first: Tensor
    last: Tensor

    def __init__(self, jitters: Tensor, first: Tensor, last: Tensor) -> None:
        super().__init__()
        for name, tensor in (("jitters", jitters), ("first", first), ("last", last)):
            self.register_buffer(name, tensor.detach().clone())

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        entry = (jitter[:, None] - self.jitters).square().sum(dim=-1).argmin(dim=1)
        return self._pick(self.first, entry), self._pick(self.last, entry)

    @staticmethod
    def _pick(kernels: Tensor, entry: Tensor) -> Tensor:
        return kernels if kernels.shape[0] == 1 else kernels[entry]
