"""The one exception that means: the user can mend this."""


class UserError(Exception):
    """A mistake that the user can mend, told in one sentence with the offending value and what to do.

    Entry points print its message without a stack trace and exit with status 2.
    """


def was_interrupted(error: BaseException | None) -> bool:
    """Whether Ctrl-C or SIGTERM began what ended as ``error``: libraries turn it into errors of their own."""
    while error is not None:
        if isinstance(error, (KeyboardInterrupt, SystemExit)):
            return True
        error = error.__cause__ or error.__context__
    return False
