"""The one exception that means: the user can mend this."""

import errno
import gc
import traceback
from collections.abc import Iterator


class UserError(Exception):
    """A mistake that the user can mend, told in one sentence with the offending value and what to do.

    Entry points print its message without a stack trace and exit with status 2.
    """


def chain(error: BaseException | None) -> Iterator[BaseException]:
    """An error and what led to it, each once (libraries wrap what our code raises)."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        yield error
        seen.add(id(error))
        error = error.__cause__ or error.__context__


def was_interrupted(error: BaseException) -> bool:
    """Whether Ctrl-C or SIGTERM began what ended as ``error``: libraries turn it into errors of their own."""
    return any(isinstance(one, (KeyboardInterrupt, SystemExit)) for one in chain(error))


def let_go(error: BaseException) -> None:
    """Clear what the frames along an exception's chain of causes hold, so that half-done transactions and files are closed.

    Frames that still run keep theirs; the stack trace stays.
    """
    for one in chain(error):
        traceback.clear_frames(one.__traceback__)
    gc.collect()


def find_user_error(error: BaseException) -> UserError | None:
    """The first mistake of the user's along an exception's chain of causes (Hydra wraps what a constructor raises)."""
    for one in chain(error):
        if isinstance(one, UserError):
            return one
        if isinstance(one, OSError) and one.errno == errno.ENOSPC:
            return UserError(
                "The disk is full: free some space, then run the same command again; it goes on from there."
            )
    return None
