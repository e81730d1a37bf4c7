"""DLCTUS's passes in C++, as a backend."""

from typing import final

import torch

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.dlctus import DLCTUS
from supersampling.models.dlctus_native import DLCTUSNative
from supersampling.profiling.backends import Backend, LoadOptions, Stream, TorchStream


@final
class Native(Backend):
    """DLCTUS in C++, see `DLCTUSNative`; no other method."""

    name = "native"

    def missing(self, device: torch.device, precision: str) -> str:
        if device.type == "cpu" and precision == "float32":
            return ""
        return f"This backend runs on the processor in float32 only, not on {device.type} in {precision}."

    def load(self, model: Upsampler, options: LoadOptions) -> Stream:
        if not isinstance(model, DLCTUS):
            raise UserError(f"The native backend runs DLCTUS only, not {type(model).__name__}: leave native out.")
        stream = TorchStream(DLCTUSNative(model), options, torch.contiguous_format)
        stream.model = None  # passes in C++ are no modules that could be timed
        return stream
