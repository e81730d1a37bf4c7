"""Slot ``kernel_prediction``: the source of the kernels of a network's first and last convolution.

Mercier et al. 2023, section 4.2, "Jitter-conditioned convolutions". Kernels are 3x3: ``(B, outputs, inputs, 3, 3)``, or
``(1, ...)`` where all items share one. An option is constructed with the two kernels that training starts from,
``(outputs, inputs, 3, 3)``.
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
    """Convolve each item of ``x (B, inputs, h, w)`` with its own 3x3 kernel; zeros outside, ``bias (outputs,)``."""
    b, c, h, w = x.shape
    if kernel.shape[0] == 1:
        return F.conv2d(x, kernel[0], bias, padding=1)
    grouped = F.conv2d(x.reshape(1, b * c, h, w), kernel.flatten(0, 1), bias.repeat(b), padding=1, groups=b)
    return grouped.view(b, -1, h, w)


class KernelPrediction(nn.Module, ABC):
    """The two kernels for a jitter, ``forward(jitter (B, 2)) -> (first, last)``."""

    @abstractmethod
    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]: ...

    def __call__(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        first, last = super().__call__(jitter)
        return first, last

    @torch.no_grad()
    def precompute(self, jitters: Tensor) -> "KernelTable":
        """Return the table of the kernels of a jitter sequence ``(N, 2)``, which is the deployed form."""
        return KernelTable(jitters, *self(jitters))


class KernelMLP(nn.Module):
    """One MLP whose outputs are all kernels, ``forward(jitter (B, 2)) -> [kernel (B, outputs, inputs, 3, 3), ...]``.

    ``layers`` counts the linear layers, including the output layer; a ReLU follows each but the last. Only kernels are
    predicted, not biases. The output layer's bias starts as the ``initial`` kernels and is stored in their shapes, so
    that an optimizer that treats matrices differently recognises them. The paper does not say how the rest starts: here
    the output layer's weights at 0, so that training starts from ordinary convolutions at any width, and the hidden
    layers with PyTorch's own initialisation.
    """

    def __init__(self, initial: Sequence[Tensor], width: int, layers: int) -> None:
        super().__init__()
        if width < 1 or layers < 2:
            raise UserError(
                f"Invalid kernel_prediction of width={width} and layers={layers}: use a width of at least 1 and at "
                "least 2 layers; the paper has 2048 and 7."
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
    """Both kernels predicted, as in the paper: 7 layers, 2048 wide (section 5).

    The paper speaks of "an MLP" for both, which is taken literally: one MLP predicts both kernels.
    """

    def __init__(self, first: Tensor, last: Tensor, width: int, layers: int) -> None:
        super().__init__()
        self.mlp = KernelMLP((first, last), width, layers)

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        first, last = self.mlp(jitter)
        return first, last


@final
class FirstOnly(KernelPrediction):
    """The first kernel predicted, the last learned: the row "(-) last jitter conv" of table 3."""

    def __init__(self, first: Tensor, last: Tensor, width: int, layers: int) -> None:
        super().__init__()
        self.mlp = KernelMLP((first,), width, layers)
        self.last = nn.Parameter(last[None])

    def forward(self, jitter: Tensor) -> tuple[Tensor, Tensor]:
        (first,) = self.mlp(jitter)
        return first, self.last


@final
class LastOnly(KernelPrediction):
    """The last kernel predicted, the first learned: the row "(-) first jitter conv" of table 3."""

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
    """Precomputed kernels of each position of a jitter sequence: "no additional computational overhead" (section 4.2).

    A jitter takes the nearest entry, so a jitter that is not in the sequence gets the kernel of another one.

    Args:
        jitters: ``(N, 2)``.
        first, last: ``(N, outputs, inputs, 3, 3)``, or ``(1, ...)`` for a kernel that does not depend on the jitter.
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
        return self._select(self.first, entry), self._select(self.last, entry)

    @staticmethod
    def _select(kernels: Tensor, entry: Tensor) -> Tensor:
        return kernels if kernels.shape[0] == 1 else kernels[entry]
