"""Files that HDF5 writes, closed safely when the disk is full."""

import io
from pathlib import Path
from typing import Any


class OutputFile(io.FileIO):
    """A new file, also readable, for ``h5py.File(output, "w")``.

    The system's first error is kept for `check`, and what HDF5 writes afterwards is dropped: HDF5 cannot close a file
    whose writes fail, complains of each of its objects, and crashes when the process ends.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self._error: OSError | None = None

    def check(self) -> None:
        """Raise the first error of the system, if there was any."""
        if self._error is not None:
            raise self._error

    def write(self, data: Any) -> int:
        """Write all bytes: a nearly full disk takes a part of them without an error."""
        rest = memoryview(data).cast("B")
        length = len(rest)
        try:
            while rest and self._error is None:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self._error = error
        return length

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self._error = self._error or error
            return size or 0
