"""Opening of HDF5 files, and what an error of HDF5 means: each cause has a sentence that says what to do."""

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from supersampling.errors import DamagedFile, UserError, describe_system_error
from supersampling.files import check_regular_file

HDF5_ERRORS = (OSError, RuntimeError, KeyError, ValueError, TypeError, MemoryError)
"""What h5py raises for files that it cannot read: all but OSError depend on the place of the damage."""

RESTORE = "restore it from a copy, or move it away and render or import it again"
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SIZES = re.compile(r"truncated file: eof = (\d+), sblock->base_addr = \d+, stored_eof = (\d+)")
_ERRNO = re.compile(r"errno = (\d+)")
_CLASSES = {PermissionError: errno.EACCES, IsADirectoryError: errno.EISDIR, BlockingIOError: errno.EAGAIN}
_OPEN_FOR_WRITING = "already open for write"
_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)


def open_hdf5(path: Path) -> h5py.File:
    """Open an HDF5 file, read-only.

    Raises:
        DamagedFile: the content is no complete HDF5 file.
        MissingFile: there is no such file.
        UserError: it is no file, locked, not permitted, or the system does not open it.
    """
    try:
        check_regular_file(path)
        return h5py.File(path, "r")
    except FileNotFoundError as error:
        raise MissingFile(f"Data set {path} not found: run render.py, or correct the path.") from error
    except HDF5_ERRORS as error:
        raise explain(path, error, "") from error


class MissingFile(UserError):
    """A data set file that does not exist."""


@contextmanager
def reading(path: Path, part: str) -> Iterator[None]:
    """Turn errors of h5py into `UserError`; ``part`` is the place in the file, for the message."""
    try:
        yield
    except HDF5_ERRORS as error:
        raise explain(path, error, part) from error


def explain(path: Path, error: Exception, part: str) -> UserError:
    """Return what an error of h5py means for the user; ``part`` is the place in the file, empty for the file itself."""
    code = errno_of(error)
    if "lock file" in str(error) or code == errno.EAGAIN:
        return _explain_lock(path, code)
    if _OPEN_FOR_WRITING in str(error):
        return _explain_mark(path)
    condition = describe_system_error(OSError(code, os.strerror(code)), path) if code else None
    if condition is not None:
        return condition
    if not path.exists():
        return UserError(f"{path} was removed by another process while it was read: run the same command again.")
    reason = f"{path} {_damage(path, error, part)}"
    return DamagedFile(f"{reason}: {RESTORE}.", reason)


def errno_of(error: BaseException) -> int | None:
    """Return the system's error number; h5py has it in the message only if the error is no OSError."""
    if isinstance(error, OSError):
        return error.errno or next((code for kind, code in _CLASSES.items() if isinstance(error, kind)), None)
    match = _ERRNO.search(str(error))
    return int(match[1]) if match else None


def _explain_lock(path: Path, code: int | None) -> UserError:
    if code in _NO_LOCKS:
        return UserError(
            f"{path} is on a file system without locks ({os.strerror(code)}): set HDF5_USE_FILE_LOCKING=FALSE."
        )
    return UserError(
        f"{path} is open for writing in another process: close it there (if no process has it open, as may be on a "
        "network file system, set HDF5_USE_FILE_LOCKING=FALSE)."
    )


def _explain_mark(path: Path) -> UserError:
    """Return what the mark of a writer means: the writer still runs, or ended without closing the file."""
    if _is_locked(path):
        return _explain_lock(path, None)
    return UserError(
        f"{path} was not closed by the process that wrote it last: close it there if that process still runs, "
        f"otherwise clear its mark with h5clear -s {path} (of hdf5-tools), which keeps the content."
    )


def _is_locked(path: Path) -> bool:
    try:
        import fcntl
    except ImportError:  # Windows
        return False
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks
            return False
    return False


def _damage(path: Path, error: Exception, part: str) -> str:
    """Return what is broken in the content of a file, to follow the file's name."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(len(_SIGNATURE))
    match = _SIZES.search(str(error))
    if not size:
        return "is empty"
    if match:
        return f"is truncated (it has {match[1]} of {match[2]} bytes)"
    if "signature not found" in str(error) and head != _SIGNATURE:
        return f"is not an HDF5 file (it begins with {head!r})"
    if part:
        return f"is damaged in {part} ({_first_line(error)})"
    return f"is an HDF5 file that is truncated or damaged ({_first_line(error)})"


def _first_line(error: Exception) -> str:
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    inner = re.search(r"\((.+?)[\n)]", text)
    return (inner[1] if inner else text.splitlines()[0] if text else type(error).__name__)[:120]
