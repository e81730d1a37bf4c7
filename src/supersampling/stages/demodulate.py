"""Slot ``demodulate``: the quantity that is super-resolved, and its display (Li et al. 2024, NSRD, section 3.1)."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import final

import torch
from torch import Tensor, nn

from supersampling.frames import Frame
from supersampling.ops.demodulate import demodulate, remodulate
from supersampling.ops.display import radiance_to_display


class Demodulate(nn.Module, ABC):
    """The network's colour input, ``forward(frame) -> (B, 3, h, w)``; the network's output is in the same domain.

    ``requires`` names the buffers that `forward` and `present` read, ``compares`` those that `reference` reads, as in
    `supersampling.models.base.Upsampler`.
    """

    requires: frozenset[str]
    compares: frozenset[str]

    @abstractmethod
    def forward(self, frame: Frame) -> Tensor: ...

    @abstractmethod
    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        """Return what outputs are compared with, ``(B, T, 3, H, W)``."""

    @abstractmethod
    def present(self, output: Tensor, frame: Frame) -> Tensor:
        """Return the display-referred image ``(B, 3, H, W)`` in [0, 1] of an output ``(B, 3, H, W)``."""

    @abstractmethod
    def radiance(self, output: Tensor, frame: Frame) -> Tensor | None:
        """Return the linear radiance ``(B, 3, H, W)`` of an output, or None if only display colours are known."""


@final
class DisplayColour(Demodulate):
    """The displayed image itself, in [0, 1]: the input of methods that do not read radiance (Xiao et al. 2020)."""

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
    """The lighting component, non-negative and unbounded, remodulated with high-resolution material (eqs 2 to 4).

    Emission and sky bypass the network, at high resolution. Negative lighting, which a network can predict, is set to
    0.
    """

    requires = frozenset({"radiance", "material", "emission", "high_material", "high_emission"})
    compares = frozenset({"target_radiance", "high_material", "high_emission"})

    def forward(self, frame: Frame) -> Tensor:
        return demodulate(*frame.need("radiance", "material", "emission"))

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return demodulate(clip["target_radiance"], clip["high_material"], clip["high_emission"])

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return radiance_to_display(self.radiance(output, frame))

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return remodulate(output.clamp(min=0.0), *frame.need("high_material", "high_emission"))


@final
class LoggedLighting(Demodulate):
    """``ln(1 + I)`` of the non-negative lighting component ``I``.

    An addition of this framework: near a lamp, or on a dark and shiny surface, lighting is thousands of times what it
    is elsewhere, and single pixels then dominate a network's features, gradients and loss. The map is exact in both
    directions; outputs are clamped to the largest lighting that float16 can hold.
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
        return radiance_to_display(self.radiance(output, frame))

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return self.linear.radiance(output.clamp(max=self.highest).expm1(), frame)


@final
class Radiance(Demodulate):
    """The radiance itself, linear and unbounded, with the material in it: demodulation off (figure 7)."""

    requires = frozenset({"radiance"})
    compares = frozenset({"target_radiance"})

    def forward(self, frame: Frame) -> Tensor:
        return frame.need("radiance")

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return clip["target_radiance"]

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return radiance_to_display(output)

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return output


@final
class LoggedRadiance(Demodulate):
    """``ln(1 + L)`` of the radiance ``L``, with the material in it: demodulation off, in the space of `LoggedLighting`.

    An addition of this framework: against `LoggedLighting` only the material differs, and losses of both are of
    logarithms. `Radiance` against it would change the scale of what the network reads and of its loss as well.
    """

    requires = Radiance.requires
    compares = Radiance.compares
    highest = LoggedLighting.highest

    def forward(self, frame: Frame) -> Tensor:
        return frame.need("radiance").log1p()

    def reference(self, clip: Mapping[str, Tensor]) -> Tensor:
        return clip["target_radiance"].log1p()

    def present(self, output: Tensor, frame: Frame) -> Tensor:
        return radiance_to_display(self.radiance(output, frame))

    def radiance(self, output: Tensor, frame: Frame) -> Tensor:
        return output.clamp(min=0.0, max=self.highest).expm1()
