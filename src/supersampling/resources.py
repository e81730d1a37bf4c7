"""The folder of the files that travel with the code: ``conf``, ``sweeps``, ``reports/published`` and
``reports/templates``."""

import os
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
VARIABLE = "SUPERSAMPLING_ROOT"


def resources() -> Path:
    """Return the checkout's root, or the copy of those folders inside an installed package."""
    packaged = PACKAGE / "resources"
    return packaged if packaged.is_dir() else PACKAGE.parents[1]


def output_root() -> Path:
    """Return the folder that data sets, the MLflow store and reports are written to: ``SUPERSAMPLING_ROOT``."""
    return Path(os.environ.get(VARIABLE, os.curdir)).resolve()
