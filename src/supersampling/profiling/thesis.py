"""DLCTUS with the optimisations of the thesis's implementation as backends (Swensen 2021, 4.4.4, tables 7, 8 and 12).

All run in PyTorch's eager mode, so that `eager` is the thesis's row without optimisations.
"""

from abc import abstractmethod
from typing import final

import torch

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.dlctus import DLCTUS
from supersampling.models.dlctus_inference import DLCTUSForInference, DLCTUSWithoutShuffle
from supersampling.models.precision import missing_arithmetic
from supersampling.profiling.backends import Backend, LoadOptions, TorchStream


class Rewritten(Backend):
    """DLCTUS after a rewrite of equal output; no other method."""

    def missing(self, device: torch.device, precision: str) -> str:
        return missing_arithmetic(device, precision)

    def load(self, model: Upsampler, options: LoadOptions) -> TorchStream:
        if not isinstance(model, DLCTUS):
            raise UserError(
                f"The {self.name} backend runs DLCTUS only, not {type(model).__name__}: leave {self.name} out."
            )
        return TorchStream(self.rewrite(model), options, torch.contiguous_format)

    @abstractmethod
    def rewrite(self, model: DLCTUS) -> Upsampler:
        """Return the rewritten copy."""


@final
class Optimisation1(Rewritten):
    """Optimisation 1: output construction reads the network's channels in place of a pixel shuffle."""

    name = "thesis_1"

    def rewrite(self, model: DLCTUS) -> Upsampler:
        return DLCTUSWithoutShuffle(model)


@final
class Optimisations1And2(Rewritten):
    """Optimisations 1 and 2: input preparation also writes the input in the order that a 1x1 convolution reads."""

    name = "thesis_1_2"

    def rewrite(self, model: DLCTUS) -> Upsampler:
        return DLCTUSForInference(model)
