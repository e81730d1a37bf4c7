"""The one exception that means that the user can correct something, and what led to an exception."""

import errno
import gc
import re
import traceback
from collections.abc import Iterator
from pathlib import Path

# Of an error in a data loader's process: PyTorch raises the same class again with the stack trace as its message.
_IN_WORKER = re.compile(r"\ACaught \S+ in DataLoader worker process .*\n\S*: (?P<message>[^\n]+)\s*\Z", re.DOTALL)
_FULL = "free some space, then run the same command again; it continues from there."
# Conditions of the machine, never errors of a program. ``{file}`` is the file's name, ``{limit}`` the process' limit of
# open files.
_SYSTEM = {
    errno.ENOSPC: f"The disk is full: {_FULL}",
    errno.EDQUOT: f"Your disk quota is used up: {_FULL}",
    errno.EFBIG: "{file} would be larger than its file system or the limit of ulimit -f allows: raise the limit, or "
    "use another folder.",
    errno.EROFS: "{file} is on a file system that is read-only: use another folder.",
    errno.EACCES: "No permission for {file}: change its permissions, or run as the user who owns it.",
    errno.EPERM: "No permission for {file}: change its permissions, or run as the user who owns it.",
    errno.EMFILE: "{file} cannot be opened because this process has too many open files: raise the limit of {limit} "
    "with ulimit -n.",
    errno.ENFILE: "{file} cannot be opened because this machine has too many open files: close other programs, or "
    "raise fs.file-max.",
    errno.EIO: "The disk reports an error for {file} (input/output error): check the disk and its connection, and copy "
    "the file to another one.",
    errno.ESTALE: "{file} has vanished from its network file system while it was open: run the same command again.",
    errno.ENOLCK: "{file} is on a file system without locks: use a folder on another one.",
    errno.ELOOP: "{file} is a link that leads to itself: correct the link.",
    errno.ENAMETOOLONG: "The name {file} is too long for the file system: use a shorter one.",
    errno.ENOTDIR: "{file} does not exist, because a folder in its path is a file: correct the path.",
    errno.EISDIR: "{file} is a folder: name a file.",
}


class UserError(Exception):
    """A mistake that the user can correct: one sentence with the offending value, and what to do.

    Commands print its message without a stack trace and exit with status 2.
    """


class TimeLimitReached(Exception):
    """A training that stopped at its time limit, with a checkpoint: the message says where.

    Commands print it without a stack trace and exit with a status of its own.
    """


class DamagedFile(UserError):
    """A file whose content is broken beyond doubt; ``reason`` is the message without what to do."""

    def __init__(self, message: str, reason: str = "") -> None:
        super().__init__(message)
        self.reason = reason or message


def describe_system_error(error: OSError, path: Path | None = None) -> UserError | None:
    """Return what a condition of the machine means for a file, None for any other error.

    Args:
        path: the file, if the error does not name it.
    """
    if error.errno not in _SYSTEM:
        return None
    file = path or error.filename or "A file"
    return UserError(_SYSTEM[error.errno].format(file=file, limit=open_file_limit()))


def open_file_limit() -> int | None:
    """Return how many files this process may have open, None if the system sets no limit."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return None if limit == resource.RLIM_INFINITY else limit


def chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error and those that led to it, each once (libraries wrap what our code raises)."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        yield error
        seen.add(id(error))
        error = error.__cause__ or error.__context__


def first_line(error: BaseException) -> str:
    """Return the first line of an error's message, the error's class if it has none."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def find_user_error(error: BaseException) -> UserError | None:
    """Return the first user mistake along an exception's chain of causes: Hydra wraps what a constructor raises."""
    for cause in chain(error):
        if isinstance(cause, UserError):
            match = _IN_WORKER.match(str(cause))
            return UserError(match["message"]) if match else cause
        if isinstance(cause, OSError) and (condition := describe_system_error(cause)):
            return condition
    return None


def find_time_limit(error: BaseException) -> TimeLimitReached | None:
    """Return the time limit that led to ``error``, None if none did."""
    return next((cause for cause in chain(error) if isinstance(cause, TimeLimitReached)), None)


def was_interrupted(error: BaseException) -> bool:
    """Return whether Ctrl-C or SIGTERM led to ``error``: libraries turn them into errors of their own."""
    return any(isinstance(cause, (KeyboardInterrupt, SystemExit)) for cause in chain(error))


def clear_traceback_frames(error: BaseException) -> None:
    """Clear the local variables along an exception's chain of causes: that closes half-done transactions and files.

    Frames that still run keep theirs; the stack trace stays.
    """
    for cause in chain(error):
        traceback.clear_frames(cause.__traceback__)
    gc.collect()
