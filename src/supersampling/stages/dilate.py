"""Slot ``dilate``: the choice of a low-resolution motion vector for each pixel (Swensen 2021, 2.4.3 and 5.5.2)."""

from abc import ABC, abstractmethod
from typing import final

import torch
import torch.nn.functional as F
from torch import Tensor, nn


class Dilate(nn.Module, ABC):
    """Motion at low resolution, ``forward(motion (B, 2, h, w), depth (B, 1, h, w) or None) -> (B, 2, h, w)``.

    ``requires`` names the buffers that are read; ``depth`` may be None where it is not among them.
    """

    requires: frozenset[str]

    @abstractmethod
    def forward(self, motion: Tensor, depth: Tensor | None) -> Tensor: ...


@final
class NoDilation(Dilate):
    """The motion of each pixel itself."""

    requires = frozenset({"motion"})

    def forward(self, motion: Tensor, depth: Tensor | None) -> Tensor:
        return motion


@final
class ClosestDepth(Dilate):
    """The motion of the pixel nearest to the camera in the 3x3 neighbourhood; a tie keeps the pixel's own motion."""

    requires = frozenset({"motion", "depth"})

    def forward(self, motion: Tensor, depth: Tensor | None) -> Tensor:
        if depth is None:
            raise ValueError("The frame has no depth: add the buffer to the model's requires.")
        _, _, h, w = depth.shape
        nearest, index = F.max_pool2d(-depth, kernel_size=3, stride=1, padding=1, return_indices=True)
        identity = torch.arange(h * w, device=depth.device).view(1, 1, h, w)
        index = torch.where(nearest == -depth, identity, index)
        return motion.flatten(2).gather(2, index.flatten(2).expand(-1, 2, -1)).view_as(motion)
