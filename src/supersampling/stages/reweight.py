"""Slot ``reweight``: a weight of each pixel of each previous frame (Xiao et al. 2020, 3.2.3 and table 10)."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor, nn

from supersampling.errors import UserError
from supersampling.stages.gate import OPEN, SHUT, Gate, bias_at

RGBD = 4


class Reweight(nn.Module, ABC):
    """The reweighted previous frames, ``forward(current (B, C, H, W), past (B, previous, C, H, W)) -> past``.

    Colour and depth are the first four of the ``C`` channels. A method calls the option with the number of ``previous``
    frames.
    """

    @abstractmethod
    def forward(self, current: Tensor, past: Tensor) -> Tensor: ...

    @abstractmethod
    def images(self, current: Tensor, past: Tensor) -> dict[str, Tensor]:
        """Return the weights of each previous frame by name, ``(B, 1, H, W)``, 1 for the largest possible (figure 5e).

        ``reweighting_1`` is of the newest previous frame.
        """


@final
class LearnedWeights(Reweight):
    """A weight in (0, limit) for each pixel of each previous frame, on all its channels (figure 4, orange).

    Three convolutions 3x3, 32-32-previous, over colour and depth of all frames; two ReLUs (the text names no
    activation), then a tanh, mapped from (-1, 1) to (0, limit). 13,314 parameters with 2 previous frames, 16,196 with
    4.
    """

    extremes = (
        Gate("reweight/0", "NSRR: previous frames have weight 0.", bias_at(SHUT, lambda m: m.network[-2].bias)),
        Gate(
            "reweight/limit",
            "NSRR: previous frames have the largest weight, 10.",
            bias_at(OPEN, lambda m: m.network[-2].bias),
        ),
    )

    def __init__(self, previous: int, width: int = 32, limit: float = 10.0) -> None:
        super().__init__()
        if not limit > 0.0:
            raise UserError(f"Invalid model.reweight.limit={limit}: use a positive number; the paper has 10.")
        self.limit = limit
        self.network = nn.Sequential(
            nn.Conv2d(RGBD * (previous + 1), width, 3, padding=1),
            nn.ReLU(inplace=True),
            nn.Conv2d(width, width, 3, padding=1),
            nn.ReLU(inplace=True),
            nn.Conv2d(width, previous, 3, padding=1),
            nn.Tanh(),
        )

    def forward(self, current: Tensor, past: Tensor) -> Tensor:
        return past * self._weights(current, past).unsqueeze(2)

    def images(self, current: Tensor, past: Tensor) -> dict[str, Tensor]:
        weights = (self._weights(current, past) / self.limit).split(1, dim=1)
        return {f"reweighting_{k + 1}": weight for k, weight in enumerate(weights)}

    def _weights(self, current: Tensor, past: Tensor) -> Tensor:
        """Return ``(B, previous, H, W)`` in (0, limit)."""
        rgbd = torch.cat((current[:, :RGBD], past[:, :, :RGBD].flatten(1, 2)), dim=1)
        return (self.network(rgbd) + 1.0) * (0.5 * self.limit)


@final
class NoReweighting(Reweight):
    """Previous frames unchanged (table 10)."""

    def __init__(self, previous: int) -> None:
        super().__init__()

    def forward(self, current: Tensor, past: Tensor) -> Tensor:
        return past

    def images(self, current: Tensor, past: Tensor) -> dict[str, Tensor]:
        return {}
