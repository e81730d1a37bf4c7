"""What a process holds of the memory, and how much it may."""

import ctypes
import sys
from pathlib import Path

import torch

# Of glibc's mallopt.
_MMAP_MAX, _TRIM_THRESHOLD = -4, -1
_VICTIM = Path("/proc/self/oom_score_adj")
_STATUS, _INFO, _CLEAR = Path("/proc/self/status"), Path("/proc/meminfo"), Path("/proc/self/clear_refs")


def held(device: torch.device) -> int:
    """Bytes that this process holds now: on CUDA those of PyTorch's tensors, else resident memory."""
    if device.type == "cuda":
        return torch.cuda.memory_allocated(device)
    return _line(_STATUS, "VmRSS") or _largest()


def peak(device: torch.device) -> int:
    """Bytes that it held at most since `forget_peak`, as `held` counts them."""
    if device.type == "cuda":
        return torch.cuda.max_memory_allocated(device)
    return _line(_STATUS, "VmHWM") or _largest()


def forget_peak(device: torch.device) -> None:
    """From here on, `peak` counts anew; where the system cannot do that, it goes on counting from the process's start."""
    if device.type == "cuda":
        torch.cuda.reset_peak_memory_stats(device)
        return
    if not sys.platform.startswith("linux"):
        return
    getattr(ctypes.CDLL(None), "malloc_trim", lambda _: 0)(0)
    try:
        _CLEAR.write_text("5")
    except OSError:
        return


def available() -> int | None:
    """Bytes that could still be taken without swapping; None where the system does not say."""
    return _line(_INFO, "MemAvailable") or None


def keep() -> None:
    """Let this process keep what it frees, as renderers and inference runtimes do.

    glibc gives each buffer of over 32 MB back to the system, and the next one is first touched page by page: at 3840x2160, where
    most planes are larger, that takes more than half of a frame's time in PyTorch.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform.startswith("linux") else None
    if mallopt is not None:
        mallopt(_MMAP_MAX, 0)
        mallopt(_TRIM_THRESHOLD, -1)


def allow(more: int) -> None:
    """Let this process take so many bytes more than it holds: a request beyond fails.

    Should the machine run out of memory all the same, this process is the one to be ended.
    """
    import resource

    if _VICTIM.is_file():
        _VICTIM.write_text("1000")

    now = _line(_STATUS, "VmData")
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (now + more, hard))


def _line(path: Path, name: str) -> int:
    """Bytes that a file of ``/proc`` tells in kB; 0 if it does not."""
    if not path.is_file():
        return 0
    found = [line for line in path.read_text().splitlines() if line.startswith(f"{name}:")]
    return int(found[0].split()[1]) * 1024 if found else 0


def _largest() -> int:
    """The largest resident memory so far, where ``/proc`` is not there."""
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024
