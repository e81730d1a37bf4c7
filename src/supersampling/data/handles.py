"""Open data set files: each is opened when it is read, and at most a share of the files that a process may have."""

import itertools
import os
import weakref
from pathlib import Path
from typing import Any

import h5py

from supersampling.data.hdf5 import open_hdf5
from supersampling.errors import UserError, open_file_limit

MOST = 64
_SHARE = 4  # the limit of open files is 1024 on most systems; libraries, data loaders and MLflow need the rest
_uses = itertools.count()
_of_parent: list[h5py.File] = []  # in a forked process: closing them would release the parent's locks
_handles: "weakref.WeakSet[Handle]" = weakref.WeakSet()


class Handle:
    """A file that is open if it was read lately; it can be pickled and used in forked processes."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: h5py.File | None = None
        self._process = os.getpid()
        self._state: tuple[int, int] = (0, 0)
        self._used = 0

    def open(self) -> tuple[h5py.File, bool]:
        """Return the open file, and whether it was opened by this call.

        Raises:
            UserError: the file cannot be opened, or its content was changed since it was opened.
        """
        self._used = next(_uses)
        if self._file is not None and self._process == os.getpid():
            self._check_unchanged()
            return self._file, False
        if self._file is not None:
            _of_parent.append(self._file)
        _close_unused()
        self._file, self._process = open_hdf5(self._path), os.getpid()
        self._state = self._read_state()
        _handles.add(self)
        return self._file, True

    def close(self) -> None:
        if self._file is not None and self._process == os.getpid():
            self._file.close()
        self._file = None

    @property
    def is_open(self) -> bool:
        return self._file is not None and self._process == os.getpid()

    @property
    def last_use(self) -> int:
        return self._used

    def _check_unchanged(self) -> None:
        if self._read_state() != self._state:
            raise changed(self._path)

    def _read_state(self) -> tuple[int, int]:
        """Return size and modification time of the open file; a renamed or removed one remains the same file."""
        assert self._file is not None
        state = os.fstat(self._file.id.get_vfd_handle())
        return state.st_size, state.st_mtime_ns

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_file": None}


def changed(path: Path) -> UserError:
    """Return the error for a file whose content is no longer the one that was read before."""
    return UserError(f"{path} was changed by another process while it was read: run the same command again.")


def _close_unused() -> None:
    """Close files that were not read for the longest time, so that one more can be opened."""
    limit = open_file_limit()
    most = MOST if limit is None else max(1, min(MOST, limit // _SHARE))
    opened = sorted((handle for handle in _handles if handle.is_open), key=lambda handle: handle.last_use)
    for handle in opened[: max(0, len(opened) - most + 1)]:
        handle.close()
