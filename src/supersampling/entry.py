"""How an entry point runs its task: the user's mistakes become one sentence, ours keep their stack trace."""

import errno
import logging
import os
import signal
import sys
import warnings
from collections.abc import Callable

from omegaconf import DictConfig

from supersampling.errors import UserError, chain, was_interrupted

USER_ERROR_STATUS = 2


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


def run(task: Callable[[DictConfig], object], cfg: DictConfig) -> None:
    """Run ``task(cfg)``; print a `UserError` as one sentence and exit with status 2; Ctrl-C and SIGTERM end it with 130."""
    _quiet()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        task(cfg)
    except (Exception, KeyboardInterrupt, SystemExit) as error:
        if was_interrupted(error):
            sys.stderr.write("\nInterrupted: the same command goes on from here.\n")
            sys.exit(130)
        user_error = find_user_error(error)
        if user_error is None:
            raise
        sys.stderr.write(f"error: {user_error}\n")
        sys.exit(USER_ERROR_STATUS)


def _quiet() -> None:
    """Silence what libraries say about themselves; warnings about the user's data stay."""
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_LOGGING_LEVEL", "ERROR")
    os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
    os.environ.setdefault("GIT_PYTHON_REFRESH", "quiet")
    warnings.filterwarnings("ignore", category=UserWarning, module=r"lightning\..*")
    warnings.filterwarnings("ignore", category=FutureWarning)
    for name in ("lightning.pytorch", "mlflow", "alembic"):
        logging.getLogger(name).setLevel(logging.ERROR)
