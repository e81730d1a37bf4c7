"""Slot ``demodulate``: what a network super-resolves, and how that becomes an image (Li et al. 2024, NSRD, section 3.1)."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import final

import torch
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.ops.demodulate import demodulate, remodulate
from supersampling.ops.display import displayed


class Demodulate(nn.Module, ABC):
    """``forward(frame) -> (B, 3, h, w)``, the network's colour input; its output is in the same domain.

    ``requires`` names what `forward` and `present` read, ``compares`` what `reference` does, as in
    `supersampling.models.base.Upsampler`.
    """

    requires: frozenset[str]
    compares: frozenset[str]

    @abstractmethod
    def forward(self, frame: Frame) -> Tensor: ...

    @abstractmethod
    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        """What outputs are compared with, ``(B, T, 3, H, W)``."""

    @abstractmethod
    def present(self, output: Tensor, frame: Frame) -> Tensor:
        """The display-referred image ``(B, 3, H, W)`` in [0, 1] of an output ``(B, 3, H, W)``."""

    @abstractmethod
    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        """The linear radiance ``(B, 3, H, W)`` of an output, or None: there are display colours alone."""


@final
class DisplayColour(Demodulate):
    """The displayed image itself, in [0, 1]: what methods see that know nothing of light (Xiao et al. 2020)."""

    requires = frozenset({"color"})
    compares = frozenset({"target"})

    def forward(self, frame: Frame) -> Tensor:
        return frame.need("color")

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return clip["target"]

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return output.clamp(0.0, 1.0)

    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        return None


@final
class Demodulated(Demodulate):
    """The lighting component, 0 or more and unbounded, remodulated with the high-resolution material (equations 2 to 4).

    Emission and sky pass beside the network, at high resolution. Negative lighting, which a network can give, counts as none.
    """

    requires = frozenset({"radiance", "material", "emission", "high_material", "high_emission"})
    compares = frozenset({"target_radiance", "high_material", "high_emission"})

    def forward(self, frame: Frame) -> Tensor:
        return demodulate(*frame.need("radiance", "material", "emission"))

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return demodulate(clip["target_radiance"], clip["high_material"], clip["high_emission"])

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return displayed(self.radiance(output, frame))

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return remodulate(output.clamp(min=0.0), *frame.need("high_material", "high_emission"))


@final
class LoggedLighting(Demodulate):
    """``ln(1 + I)`` of the lighting component ``I``, 0 or more.

    A switch of this framework: near a lamp, or on a dark and shiny surface, lighting is thousands of times what it is elsewhere,
    and single pixels then decide a network's features, gradients and loss. Exact in both directions; outputs are cut to what
    float16 holds of lighting.
    """

    requires = Demodulated.requires
    compares = Demodulated.compares
    highest = math.log1p(torch.finfo(torch.float16).max)

    def __init__(self) -> None:
        super().__init__()
        self.linear = Demodulated()

    def forward(self, frame: Frame) -> Tensor:
        return self.linear(frame).log1p()

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return self.linear.reference(clip).log1p()

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return displayed(self.radiance(output, frame))

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return self.linear.radiance(output.clamp(max=self.highest).expm1(), frame)


@final
class Radiance(Demodulate):
    """The radiance itself, linear and unbounded, material and all: demodulation off (figure 7)."""

    requires = frozenset({"radiance"})
    compares = frozenset({"target_radiance"})

    def forward(self, frame: Frame) -> Tensor:
        return frame.need("radiance")

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return clip["target_radiance"]

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return displayed(output)

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return output
