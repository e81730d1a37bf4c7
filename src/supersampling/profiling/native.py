"""DLCTUS's passes in C++, as a backend."""

from typing import final

import torch

from supersampling.errors import UserError
from supersampling.models.base import Upsampler
from supersampling.models.dlctus import DLCTUS
from supersampling.models.dlctus_native import DLCTUSNative
from supersampling.profiling.backends import Backend, Setting, Stream, TorchStream


@final
class Native(Backend):
    """See `DLCTUSNative`."""

    name = "native"

    def missing(self, device: torch.device, precision: str) -> str:
        if device.type == "cpu" and precision == "float32":
            return ""
        return f"It computes on the processor in float32 alone, not on {device.type} in {precision}."

    def load(self, model: Upsampler, setting: Setting) -> Stream:
        if not isinstance(model, DLCTUS):
            raise UserError(f"The native backend has DLCTUS alone, not {type(model).__name__}.")
        stream = TorchStream(DLCTUSNative(model), setting, torch.contiguous_format)
        stream.model = None  # passes in C++ are no parts that could be timed
        return stream
