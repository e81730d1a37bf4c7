"""The one exception that means: the user can mend this."""


class UserError(Exception):
    """A mistake that the user can mend, told in one sentence with the offending value and what to do.

    Entry points print its message without a stack trace and exit with status 2.
    """
