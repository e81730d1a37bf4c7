"""Memory of this process and of the machine: use, peak, free bytes, and limits."""

import ctypes
import sys
from pathlib import Path

import torch

# Parameters of glibc's mallopt.
_MMAP_MAX, _TRIM_THRESHOLD = -4, -1
_OOM_SCORE = Path("/proc/self/oom_score_adj")
_STATUS, _INFO, _CLEAR = Path("/proc/self/status"), Path("/proc/meminfo"), Path("/proc/self/clear_refs")


def usage(device: torch.device) -> int:
    """Return the bytes that this process uses now: PyTorch's tensors on CUDA, else resident memory."""
    if device.type == "cuda":
        return torch.cuda.memory_allocated(device)
    return _read_bytes(_STATUS, "VmRSS") or _largest_resident()


def peak(device: torch.device) -> int:
    """Return the most bytes that this process used since `reset_peak`, counted as `usage` does."""
    if device.type == "cuda":
        return torch.cuda.max_memory_allocated(device)
    return _read_bytes(_STATUS, "VmHWM") or _largest_resident()


def reset_peak(device: torch.device) -> None:
    """Let `peak` count from now on; if the system cannot do that, it still counts from the start of the process."""
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


def available(device: torch.device) -> int | None:
    """Return the free bytes of a device, of the processor without swapping; None if the system does not say."""
    if device.type == "cuda":
        return torch.cuda.mem_get_info(device)[0]
    return _read_bytes(_INFO, "MemAvailable") or None


def retain_freed() -> None:
    """Let this process keep the memory that it frees, as renderers and inference runtimes do.

    glibc returns each buffer of over 32 MB to the system, and the next one is touched for the first time page by page.
    At 3840x2160, where most planes are larger, that takes more than half of a frame's time in PyTorch.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform.startswith("linux") else None
    if mallopt is not None:
        mallopt(_MMAP_MAX, 0)
        mallopt(_TRIM_THRESHOLD, -1)


def limit_growth(more: int) -> None:
    """Let this process use at most ``more`` bytes more than now: a larger request fails.

    If the machine runs out of memory nevertheless, the system ends this process first.
    """
    import resource

    if _OOM_SCORE.is_file():
        _OOM_SCORE.write_text("1000")

    now = _read_bytes(_STATUS, "VmData")
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    resource.setrlimit(resource.RLIMIT_DATA, (now + more, hard))


def _read_bytes(path: Path, name: str) -> int:
    """Return an entry of a ``/proc`` file, which is in kB, in bytes; 0 if it is missing."""
    if not path.is_file():
        return 0
    matches = [line for line in path.read_text().splitlines() if line.startswith(f"{name}:")]
    return int(matches[0].split()[1]) * 1024 if matches else 0


def _largest_resident() -> int:
    """Return the largest resident memory so far, for systems without ``/proc``."""
    import resource

    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return largest if sys.platform == "darwin" else largest * 1024
