"""The start of a process: libraries are silent, and SIGTERM ends it as Ctrl-C does."""

import logging
import os
import signal
import warnings


def prepare_process() -> None:
    """Silence what libraries report about themselves, and raise `KeyboardInterrupt` on SIGTERM.

    Warnings about the user's data stay.
    """
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_LOGGING_LEVEL", "ERROR")
    os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
    os.environ.setdefault("GIT_PYTHON_REFRESH", "quiet")
    os.environ.setdefault("TORCH_CPP_LOG_LEVEL", "ERROR")  # of processes that start later
    warnings.filterwarnings("ignore", category=UserWarning, module=r"lightning\..*")
    warnings.filterwarnings("ignore", category=FutureWarning)
    for library in ("lightning.pytorch", "lightning.fabric", "mlflow", "alembic"):
        logging.getLogger(library).setLevel(logging.ERROR)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
