"""Precisions that methods are computed in, and whether a device has them."""

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import torch
from torch import nn

TYPES = {"float32": torch.float32, "bfloat16": torch.bfloat16, "float16": torch.float16, "int8": torch.int8}
# Processor flags as Linux lists them. Without one of them the type is emulated, which is slower than float32.
_FLAGS = {"bfloat16": {"avx512_bf16", "amx_bf16", "bf16"}, "float16": {"avx512_fp16", "amx_fp16", "asimdhp"}}
_CPUINFO = Path("/proc/cpuinfo")


def autocast(device: str, precision: str) -> AbstractContextManager[object]:
    """Return a context in which convolutions and matrix products are computed in a precision, as in training."""
    return nullcontext() if precision == "float32" else torch.autocast(device, TYPES[precision])


def missing_arithmetic(device: torch.device, precision: str) -> str:
    """Return why a device does not compute in a precision natively, in one sentence; an empty string if it does."""
    if precision == "float32":
        return ""
    if precision == "int8":
        return "This backend does not compute in int8, which needs a quantised graph: use backends=[int8]."
    if device.type == "cuda":
        supported = precision == "float16" or torch.cuda.is_bf16_supported(including_emulation=False)
    elif device.type == "cpu":
        supported = not _FLAGS[precision].isdisjoint(_processor_flags())
    else:
        supported = True
    unit = "processor" if device.type == "cpu" else "device"
    return "" if supported else f"This {unit} has no {precision} arithmetic."


def missing_convolution(device: str, precision: str) -> str:
    """Return why a small convolution fails in a precision, emulated or not; an empty string if it runs."""
    try:
        layer = nn.Conv2d(4, 4, 3, device=device)
        with autocast(device, precision):
            layer(torch.zeros(1, 4, 8, 8, device=device))
    except (RuntimeError, NotImplementedError) as error:
        return f"{device} has no {precision} convolution here ({str(error).splitlines()[0]})"
    return ""


def _processor_flags() -> set[str]:
    """Return the flags of this processor; an empty set if the system does not list them."""
    if not _CPUINFO.is_file():
        return set()
    lines = _CPUINFO.read_text().splitlines()
    flags = next((line for line in lines if line.lower().startswith(("flags", "features"))), "")
    return set(flags.partition(":")[2].split())
