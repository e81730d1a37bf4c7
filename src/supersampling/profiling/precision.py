"""Which arithmetic a device has."""

from pathlib import Path

import torch

TYPES = {
    "float32": torch.float32, "bfloat16": torch.bfloat16, "float16": torch.float16, "int8": torch.int8,
}  # fmt: skip
# Of a processor, as Linux lists them; without one, the type is emulated, and slower than float32.
_FLAGS = {"bfloat16": {"avx512_bf16", "amx_bf16", "bf16"}, "float16": {"avx512_fp16", "amx_fp16", "asimdhp"}}
_CPUINFO = Path("/proc/cpuinfo")


def lacking(device: torch.device, precision: str) -> str:
    """Why a device does not compute in a precision, one sentence; empty if it does."""
    if precision == "float32":
        return ""
    if precision == "int8":
        return "It does not compute in int8: that needs a quantised graph."
    if device.type == "cuda":
        has = precision == "float16" or torch.cuda.is_bf16_supported(including_emulation=False)
    elif device.type == "cpu":
        has = not _FLAGS[precision].isdisjoint(_processor_flags())
    else:
        has = True
    what = "processor" if device.type == "cpu" else "device"
    return "" if has else f"This {what} has no {precision} arithmetic."


def _processor_flags() -> set[str]:
    if not _CPUINFO.is_file():
        return set()
    lines = _CPUINFO.read_text().splitlines()
    found = next((line for line in lines if line.lower().startswith(("flags", "features"))), "")
    return set(found.partition(":")[2].split())
