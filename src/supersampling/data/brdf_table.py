"""The pre-integrated BRDF table, cached in the process and in a folder on disk."""

import contextlib
import functools
import os
import tempfile
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from supersampling.ops.brdf import integrate_table

# Increase it when the values of `integrate_table` change: files of other versions are ignored.
VERSION = 1


def cache_folder() -> Path:
    """Return ``$SUPERSAMPLING_CACHE``, else ``$XDG_CACHE_HOME/supersampling``, else ``~/.cache/supersampling``.

    Raises:
        RuntimeError: neither variable is set, and the user has no home folder.
    """
    if folder := os.environ.get("SUPERSAMPLING_CACHE"):
        return Path(folder).expanduser()
    if shared := os.environ.get("XDG_CACHE_HOME"):
        return Path(shared) / "supersampling"
    return Path.home() / ".cache" / "supersampling"


# The first call may come from a validation loop: a tensor created in its inference mode cannot take part in training.
@functools.cache
@torch.inference_mode(False)
def brdf_table(size: int = 512, samples: int = 1024) -> Tensor:
    """Return the table of `supersampling.ops.brdf.integrate_table`, ``(2, size, size)`` float32, and cache it on disk.

    A truncated or invalid file is replaced. If the folder cannot be written, the table stays in memory only. Every call
    in a process returns the same tensor: do not write to it.
    """
    path = None
    # The user may have no home folder.
    with contextlib.suppress(RuntimeError):
        path = cache_folder() / f"brdf_v{VERSION}_{size}_{samples}.npy"
    cached = None if path is None else _read(path, size)
    if cached is not None:
        return cached
    table = integrate_table(size, samples)
    if path is not None:
        # The folder may be read-only, full or missing: the next process then computes the table again.
        with contextlib.suppress(OSError):
            _write(path, table)
    return table


def _read(path: Path, size: int) -> Tensor | None:
    """Return the table in a file; None if the file is not a valid table."""
    try:
        with path.open("rb") as file:
            values = np.load(file, allow_pickle=False)
    # NumPy raises a dozen kinds of errors for damaged files, which all mean the same here.
    except Exception:
        return None
    if not isinstance(values, np.ndarray) or values.dtype != np.float32 or values.shape != (2, size, size):
        return None
    # A crash may leave blocks of zeros or noise: A and B are positive everywhere, and their sum is at most 1.
    if not (values.min() > 0.0 and values.sum(axis=0).max() <= 1.0 + 1e-5):
        return None
    return torch.from_numpy(values)


def _write(path: Path, table: Tensor) -> None:
    """Write a temporary file and rename it, so that other processes never read a part of the table."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        temporary = Path(file.name)
        try:
            np.save(file, table.numpy(force=True), allow_pickle=False)
            file.close()
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
