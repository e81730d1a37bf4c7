"""The start of a process: libraries are silent, and SIGTERM ends it as Ctrl-C does."""

import logging
import os
import signal
import warnings
from pathlib import Path


def prepare_process() -> None:
    """Silence what libraries report about themselves, and raise `KeyboardInterrupt` on SIGTERM.

    Warnings about the user's data stay, as plain lines.
    """
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_LOGGING_LEVEL", "ERROR")
    os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
    os.environ.setdefault("GIT_PYTHON_REFRESH", "quiet")
    os.environ.setdefault("TORCH_CPP_LOG_LEVEL", "ERROR")  # of processes that start later
    warnings.filterwarnings("ignore", category=UserWarning, module=r"lightning\..*")
    warnings.filterwarnings("ignore", category=FutureWarning)
    warnings.formatwarning = _format_warning
    silence_libraries()
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def silence_libraries() -> None:
    """Let libraries log errors only; to be repeated after Lightning is imported, which sets its own level then."""
    for library in ("lightning.pytorch", "lightning.fabric", "mlflow", "alembic"):
        logging.getLogger(library).setLevel(logging.ERROR)
    # It logs a stack trace of each error that it raises.
    logging.getLogger("mlflow.store.db.utils").setLevel(logging.CRITICAL)


_format_library_warning = warnings.formatwarning


def _format_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, line: str | None = None
) -> str:
    """Return a warning of ours about the user's data as one line; those of libraries show where they come from."""
    if category is UserWarning and Path(filename).is_relative_to(Path(__file__).parent):
        return f"warning: {message}\n"
    return _format_library_warning(message, category, filename, lineno, line)
