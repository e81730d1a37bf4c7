"""The pre-integrated BRDF table, made once and kept: in the process, and in a cache folder on disk."""

import contextlib
import functools
import os
import tempfile
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from supersampling.ops.brdf import integrate_table

VERSION = 1  # raise it when `integrate_table` gives other values: files of another version are not looked at


def cache_folder() -> Path:
    """``$SUPERSAMPLING_CACHE``, else ``$XDG_CACHE_HOME/supersampling``, else ``~/.cache/supersampling``.

    Raises:
        RuntimeError: neither variable is set, and the user has no home.
    """
    if own := os.environ.get("SUPERSAMPLING_CACHE"):
        return Path(own).expanduser()
    if shared := os.environ.get("XDG_CACHE_HOME"):
        return Path(shared) / "supersampling"
    return Path.home() / ".cache" / "supersampling"


# A validation loop may ask first: a tensor made in its inference mode would bar training from gradients.
@functools.cache
@torch.inference_mode(False)
def brdf_table(size: int = 512, samples: int = 1024) -> Tensor:
    """The table of `supersampling.ops.brdf.integrate_table`, ``(2, size, size)`` float32: read from disk, or made and written.

    A file that is truncated or not such a table is replaced. Where the folder cannot be written, the table is kept in memory
    only. Every call of a process returns the same tensor: do not write to it.
    """
    path = None
    with contextlib.suppress(RuntimeError):  # no home
        path = cache_folder() / f"brdf_v{VERSION}_{size}_{samples}.npy"
    kept = None if path is None else _read(path, size)
    if kept is not None:
        return kept
    table = integrate_table(size, samples)
    if path is not None:
        with contextlib.suppress(OSError):  # read-only, full or no folder: the next process makes it again
            _write(path, table)
    return table


def _read(path: Path, size: int) -> Tensor | None:
    """The table in a file, or none if it holds anything else."""
    try:
        with path.open("rb") as file:
            values = np.load(file, allow_pickle=False)
    except Exception:  # NumPy's errors about a damaged file are of a dozen kinds, and all mean the same here
        return None
    if not isinstance(values, np.ndarray) or values.dtype != np.float32 or values.shape != (2, size, size):
        return None
    # Blocks that a crash left as zeros, or noise: A and B are above 0 everywhere, and their sum at most 1.
    if not (values.min() > 0.0 and values.sum(axis=0).max() <= 1.0 + 1e-5):
        return None
    return torch.from_numpy(values)


def _write(path: Path, table: Tensor) -> None:
    """Write beside and rename, so that another process reads all of it or nothing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
        beside = Path(file.name)
        try:
            np.save(file, table.numpy(force=True), allow_pickle=False)
            file.close()
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)
