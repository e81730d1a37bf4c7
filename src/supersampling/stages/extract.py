"""Slot ``extract``: features of each frame's low-resolution samples, before upsampling (Xiao et al. 2020, 3.2.1)."""

from abc import ABC, abstractmethod
from typing import final

import torch
from torch import Tensor, nn


class Extract(nn.Module, ABC):
    """Features ``forward(samples (B, inputs, h, w)) -> (B, channels, h, w)``, the samples themselves first.

    A method calls the option with the number of ``inputs`` once for each extractor that it has.
    """

    channels: int

    @abstractmethod
    def forward(self, samples: Tensor) -> Tensor: ...


@final
class LearnedFeatures(Extract):
    """Three convolutions 3x3, 32-32-8, whose output is appended to their input (figure 4, green).

    The text names no activation: here a ReLU follows each convolution, including the last. 12,744 parameters with 4
    inputs.
    """

    def __init__(self, inputs: int, width: int = 32, features: int = 8) -> None:
        super().__init__()
        self.channels = inputs + features
        self.network = nn.Sequential(
            nn.Conv2d(inputs, width, 3, padding=1),
            nn.ReLU(inplace=True),
            nn.Conv2d(width, width, 3, padding=1),
            nn.ReLU(inplace=True),
            nn.Conv2d(width, features, 3, padding=1),
            nn.ReLU(inplace=True),
        )

    def forward(self, samples: Tensor) -> Tensor:
        return torch.cat((samples, self.network(samples)), dim=1)


@final
class NoExtraction(Extract):
    """The samples only (table 10)."""

    def __init__(self, inputs: int) -> None:
        super().__init__()
        self.channels = inputs

    def forward(self, samples: Tensor) -> Tensor:
        return samples
