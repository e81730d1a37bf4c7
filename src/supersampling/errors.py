"""The one exception that means that the user can correct something, and what led to an exception."""

import errno
import gc
import traceback
from collections.abc import Iterator


class UserError(Exception):
    """A mistake that the user can correct: one sentence with the offending value, and what to do.

    Commands print its message without a stack trace and exit with status 2.
    """


class TimeLimitReached(Exception):
    """A training that stopped at its time limit, with a checkpoint: the message says where.

    Commands print it without a stack trace and exit with a status of its own.
    """


def chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error and those that led to it, each once (libraries wrap what our code raises)."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        yield error
        seen.add(id(error))
        error = error.__cause__ or error.__context__


def find_user_error(error: BaseException) -> UserError | None:
    """Return the first user mistake along an exception's chain of causes: Hydra wraps what a constructor raises."""
    for cause in chain(error):
        if isinstance(cause, UserError):
            return cause
        if isinstance(cause, OSError) and cause.errno == errno.ENOSPC:
            return UserError(
                "The disk is full: free some space, then run the same command again; it continues from there."
            )
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
