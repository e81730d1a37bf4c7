import shutil
from pathlib import Path

import pytest


@pytest.fixture
def database(new_database: Path, tmp_path: Path) -> Path:
    """Return a copy of an empty store."""
    return Path(shutil.copy(new_database, tmp_path / "mlflow.db"))
