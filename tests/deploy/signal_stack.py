"""The stack on which this thread handles signals."""

import ctypes
import sys
from pathlib import Path

DISABLED = 2  # SS_DISABLE


class Stack(ctypes.Structure):
    """``stack_t`` of ``<signal.h>``."""

    _fields_ = (("start", ctypes.c_void_p), ("flags", ctypes.c_int), ("size", ctypes.c_size_t))


def signal_stack_is_there() -> bool:
    """Return whether the memory of an alternate stack, if there is one, belongs to this process.

    If it does not, the next signal ends the process.
    """
    if not sys.platform.startswith("linux"):
        return True
    stack = Stack()
    assert ctypes.CDLL(None, use_errno=True).sigaltstack(None, ctypes.byref(stack)) == 0
    if stack.flags & DISABLED or not stack.start:
        return True
    ranges = [line.split()[0].split("-") for line in Path("/proc/self/maps").read_text().splitlines()]
    return any(int(low, 16) <= stack.start and stack.start + stack.size <= int(high, 16) for low, high in ranges)
