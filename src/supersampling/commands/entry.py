"""How an entry point runs its task: the user's mistakes become one sentence, ours keep their stack trace."""

import logging
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Any

from hydra.core.hydra_config import HydraConfig
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig

from supersampling.errors import find_user_error, was_interrupted

USER_ERROR_STATUS = 2


FAILED: list[int] = []
"""The statuses of a multirun's jobs that failed."""


class ExitStatus(Callback):
    """A multirun's exit status is that of the first job that failed."""

    def on_multirun_end(self, config: DictConfig, **kwargs: Any) -> None:
        if FAILED:
            sys.stderr.write(f"{len(FAILED)} of the jobs failed; the same command repeats these alone.\n")
            sys.exit(FAILED[0])


def run(task: Callable[[DictConfig], object], cfg: DictConfig) -> None:
    """Run ``task(cfg)``; print a `UserError` as one sentence and exit with status 2; Ctrl-C and SIGTERM end it with 130.

    A multirun's other jobs go on after one that failed: see `ExitStatus`.
    """
    _quiet()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        task(cfg)
    except (Exception, KeyboardInterrupt, SystemExit) as error:
        if was_interrupted(error):
            sys.stderr.write("\nInterrupted: the same command goes on from here.\n")
            sys.exit(130)
        user_error = find_user_error(error)
        several = HydraConfig.initialized() and HydraConfig.get().mode == RunMode.MULTIRUN
        if user_error is not None:
            sys.stderr.write(f"error: {user_error}\n")
        elif several:
            traceback.print_exc()
        else:
            raise
        status = 1 if user_error is None else USER_ERROR_STATUS
        if not several:
            sys.exit(status)
        FAILED.append(status)


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
