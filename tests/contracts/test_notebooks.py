"""The notebooks run from top to bottom on a store that train.py wrote."""

import os
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("path", sorted((ROOT / "notebooks").glob("*.ipynb")), ids=lambda p: p.stem)
def test_it_runs(path, make_file, tmp_path, monkeypatch):
    files = [f"data.{s}=[{make_file(tmp_path, s)}]" for s in ("train", "val", "test")]
    job = [
        "data=files",
        "metrics=capture",
        "scene=atrium",
        *files,
        "budget=smoke",
        "model=bicubic",
        f"paths.root={tmp_path}",
    ]
    # Named outright: mlflow leaves the last store of this process in the environment, which would win.
    job.append(f"tracking_uri=sqlite:///{tmp_path}/mlflow.db")
    baselines = "baselines=[['model=jau']]"
    subprocess.run(
        [sys.executable, "train.py", *job, baselines], cwd=ROOT, check=True, capture_output=True, timeout=300
    )
    monkeypatch.setitem(os.environ, "SUPERSAMPLING_FILE", str(make_file(tmp_path, "test")))
    monkeypatch.setitem(os.environ, "MLFLOW_TRACKING_URI", f"sqlite:///{tmp_path}/mlflow.db")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(path.parent)}}).execute()
    outputs = [o for cell in notebook.cells if cell.cell_type == "code" for o in cell.outputs]
    assert any("image/png" in o.get("data", {}) for o in outputs)
